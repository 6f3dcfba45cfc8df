"""./run: selection of tests, linters, shell, and what it prints before it installs packages."""
import glob
import hashlib
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time
import zipfile

import pytest

from img_recog_helpers.pages import ROOT, read
from img_recog_helpers.processes import Process
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for

SHARED = ('.venv', os.path.join('test', 'data'))        # takes too long to make again
# what the commands do not need: each run of the unit tests loads modules that have examples, and
# counts lines
UNUSED = ('batch', 'checks', 'graph', 'loading', 'replay')

RUN_TIMEOUT_S = 180.0


def copied(folder):
    """Copy this package with the tests of the commands, and none that would run it again."""
    path = str(folder / 'img_recog')
    shutil.copytree(ROOT, path, symlinks=True, ignore=shutil.ignore_patterns(
        'build', 'devel', '.git', '.venv', '.hypothesis', 'data', '__pycache__', 'unit',
        'test_*.py'))
    for name in UNUSED:
        shutil.rmtree(os.path.join(path, 'src', 'img_recog', name))
    commands = os.path.join('test', 'unit', 'recognition', 'test_commands.py')
    os.makedirs(os.path.dirname(os.path.join(path, commands)))
    shutil.copy(os.path.join(ROOT, commands), os.path.join(path, commands))
    for name in SHARED:
        os.symlink(os.path.realpath(os.path.join(ROOT, name)), os.path.join(path, name))
    return path


@pytest.fixture(scope='module')
def checkout(tmp_path_factory):
    """A copy of this package, which is built and tested without changing the original."""
    return copied(tmp_path_factory.mktemp('checkout'))


@pytest.fixture
def env(tmp_path):
    """The environment of a user who has not sourced anything."""
    return {'HOME': str(tmp_path), 'PATH': '/usr/sbin:/usr/bin:/sbin:/bin'}


def run(checkout, env, *words, text=''):
    """Run ./run in that copy; return its exit code and output."""
    done = subprocess.run(['./run', *words], cwd=checkout, env=env, input=text.encode(),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                          timeout=RUN_TIMEOUT_S * stretch())
    return done.returncode, done.stdout.decode(errors='replace')


def write(checkout, path, text):
    with open(os.path.join(checkout, path), 'w') as file:
        file.write(text)


# Tests

SYSTEM_TEST = """
def test_tiny_passes():
    pass


def test_tiny_fails():
    raise AssertionError
"""
ROSTEST = """<launch>
  <param name="answer" value="42"/>
  <test test-name="tiny" pkg="rostest" type="paramtest">
    <param name="param_name_target" value="/answer"/>
    <param name="param_value_expected" value="42"/>
    <param name="test_duration" value="5"/>
  </test>
</launch>
"""


def test_one_kind_and_name_with_coverage(checkout, env):
    code, output = run(checkout, env, 'test', 'unit', '-k', 'test_commands')
    assert code == 0, output
    assert re.search(r'\[run\] the unit tests run \d+% of the lines of camera ', output), output
    assert re.search(r'\n[1-9]\d* passed, 0 failed, 0 skipped\n$', output), output
    with open(os.path.join(checkout, 'build', 'coverage.txt')) as file:
        table = file.read()
    assert re.search(r'src/img_recog/recognition/commands.py +\d+ +\d+ +\d+%', table), table
    assert 'src/img_recog/ros/' not in table


def test_a_failed_test_is_reported(checkout, env):
    write(checkout, 'test/system/test_tiny.py', SYSTEM_TEST)
    code, output = run(checkout, env, 'test', 'rostest', 'system', '-k', 'test_tiny')
    assert code != 0
    assert '\nFAILED pytest-system.xml: test_tiny_fails\n1 passed, 1 failed, 0 skipped\n' \
        in output, output
    code, output = run(checkout, env, 'test', '-k', 'tiny_passes or other_settings_apply_at_once')
    assert code == 0, output
    assert output.endswith('\n2 passed, 0 failed, 0 skipped\n'), output


def test_rostest_by_the_name_of_its_file(checkout, env):
    write(checkout, 'test/rostest/tiny.test', ROSTEST)
    code, output = run(checkout, env, 'test', 'rostest', '-k', 'tiny')
    assert code == 0, output
    # rostest counts itself as a test too
    assert '[img_recog.rosunit-tiny/test_param][passed]' in output, output
    assert output.endswith('\n2 passed, 0 failed, 0 skipped\n'), output


@pytest.mark.parametrize('words, named', [
    (('rostest', '-k', 'no_such_test'), 'no test of rostest matches no_such_test'),
    (('-k', 'no_such_test'), 'no test matches no_such_test'),
    (('units',), 'test takes unit, rostest or system, -k NAME and --accept; got units'),
    (('unit', '-k'), '-k needs a name')])
def test_nothing_selected_is_an_error(checkout, env, words, named):
    code, output = run(checkout, env, 'test', *words)
    assert code == 1
    assert '[run] {}\n'.format(named) in output, output


# Linters

def test_each_linter_finds_a_planted_error(env, tmp_path):
    checkout = copied(tmp_path)
    for folder in ('src', 'bench', 'test'):         # they take long
        shutil.rmtree(os.path.join(checkout, folder))
        os.makedirs(os.path.join(checkout, folder))
    texts = os.path.join('src', 'img_recog', 'command_line')      # of ./run itself
    shutil.copytree(os.path.join(ROOT, texts), os.path.join(checkout, texts))
    write(checkout, 'src/img_recog/__init__.py', 'import os\n\nANSWER: int = "42"\n')
    write(checkout, 'tools/planted.bash', '# shellcheck shell=bash\ncd $nowhere\n')
    with open(os.path.join(checkout, 'CMakeLists.txt'), 'a') as file:
        file.write('catkin_package()\n')
    code, output = run(checkout, env, 'lint')
    assert code == 1
    for linter, named in (('flake8', "'os' imported but unused"), ('mypy', 'Incompatible types'),
                          ('catkin_lint', 'catkin_package'), ('shellcheck', 'SC2086')):
        part = re.search(r'(?s)\[run\] {}:\n(.*?)(\[run\]|$)'.format(linter), output)
        assert part and named in part.group(1), output


# The shell

def test_shell_has_our_python_first_and_the_wrappers(env, tmp_path):
    (tmp_path / 'bin').mkdir()
    foreign = tmp_path / 'bin' / 'python3'
    foreign.write_text('#!/bin/sh\nexec /usr/bin/python3 -I -S "$@"\n')       # has no rospy
    foreign.chmod(0o755)
    (tmp_path / '.bashrc').write_text('export PATH=$HOME/bin:$PATH\n')
    code, output = run(ROOT, env, 'shell', text='command -v python3\n'
                       'rosrun --debug img_recog replay.py --help\necho "code $?"\nexit\n')
    assert re.search(r'(?m)^{}$'.format(os.path.join(ROOT, '.venv', 'bin', 'python3')), output)
    assert re.search(r'(?m)^\[rosrun\] Running .*{}'.format(
        os.path.join(ROOT, 'devel', 'lib', 'img_recog', 'replay.py')), output), output
    assert '\ncode 0\n' in output and 'usage: replay.py' in output, output


@pytest.mark.parametrize('given, hostname, master', [
    ({}, 'localhost', 'http://localhost:11311'),
    # what setup.bash of ROS sets
    ({'ROS_MASTER_URI': 'http://localhost:11311'}, 'localhost', 'http://localhost:11311'),
    ({'ROS_MASTER_URI': 'http://127.0.0.1:12345/'}, 'localhost', 'http://127.0.0.1:12345/'),
    ({'ROS_IP': '192.0.2.7'}, '', 'http://localhost:11311'),
    ({'ROS_HOSTNAME': 'robot'}, 'robot', 'http://localhost:11311'),
    ({'ROS_MASTER_URI': 'http://localhost.example:1'}, '', 'http://localhost.example:1'),
    ({'ROS_MASTER_URI': 'http://robot:11311'}, '', 'http://robot:11311')])
def test_the_demo_is_local_unless_the_user_says_otherwise(given, hostname, master):
    done = subprocess.run(
        ['bash', '-c', 'eval "$(sed -n "/^set_environment()/,/^}/p" run)"; '
         'build=build venv=.venv; set -eu; '
         'set_environment; echo "${ROS_HOSTNAME:-},$ROS_MASTER_URI,${ROS_IP:-}"'],
        cwd=ROOT, env={'PATH': '/usr/bin:/bin', **given}, stdout=subprocess.PIPE, check=True)
    assert done.stdout.decode() == '{},{},{}\n'.format(hostname, master, given.get('ROS_IP', ''))


# Two at once

def test_one_waits_while_another_builds_in_the_same_folder(checkout, env, tmp_path):
    calls, go_on = tmp_path / 'calls', tmp_path / 'go on'
    cmake = tmp_path / 'bin' / 'cmake'
    cmake.parent.mkdir()
    cmake.write_text('#!/bin/bash\necho "$@" >>{}\nwhile [ ! -e "{}" ]; do sleep 0.02; done\n'
                     'exec /usr/bin/cmake "$@"\n'.format(calls, go_on))
    cmake.chmod(0o755)
    shutil.rmtree(os.path.join(checkout, 'build'), ignore_errors=True)
    env = dict(env, PATH='{}:{}'.format(cmake.parent, env['PATH']))
    first = Process(['./run', 'shell', 'true'], env, cwd=checkout)
    wait_for(calls.exists, lambda: 'cmake in:\n' + first.output)
    second = Process(['./run', 'shell', 'true'], env, cwd=checkout)
    second.wait_output('waiting for another ./run in this folder\n')
    go_on.touch()
    assert first.wait() == second.wait() == 0, first.output + second.output
    assert second.output == '[run] waiting for another ./run in this folder\n'
    assert len(calls.read_text().splitlines()) == 2         # configures and builds once


def test_each_demo_has_its_own_master_and_the_shell_finds_it(checkout, env):
    def found():
        code, output = run(checkout, env, 'shell', 'printenv', 'ROS_MASTER_URI')
        return code == 0 and output.strip()

    demos = [Process(['./run', 'demo', 'camera:=none', 'recognition:=false', 'simulator:=false',
                      'web:=false'], env, cwd=checkout) for _ in range(2)]
    try:
        for demo in demos:
            demo.wait_output('no terminal to read keys from')
        # a line of roslaunch
        first, second = [demo.wait_output(r'ROS_MASTER_URI=(http://\w+:\d+)').group(1)
                         for demo in demos]
        assert first != second
        assert any('run "export ROS_MASTER_URI={}"'.format(uri) in demo.output
                   for demo, uri in zip(demos, (first, second)))
        assert found() in (first, second)
        assert demos[0].is_running() and demos[0].interrupt() == 0
        assert found() == second
        assert demos[1].is_running() and demos[1].interrupt() == 0
    finally:
        for demo in demos:
            demo.close()


# What roslaunch and rosrun find

def test_the_commands_of_the_readme_start_what_is_in_this_folder(checkout, env):
    assert [name for name, _, files in os.walk(checkout) if 'demo.launch' in files] == [
        os.path.join(checkout, 'launch')]
    commands = sorted(set(re.findall(r'(roslaunch|rosrun) img_recog ([\w.]+)', read('README.md'))))
    assert len(commands) > 4
    asked = {'roslaunch': 'roslaunch --files img_recog ',
             'rosrun': 'rosrun --prefix echo img_recog '}
    code, output = run(checkout, env, 'shell', 'bash', '-e', '-c',
                       '\n'.join(asked[program] + name for program, name in commands))
    assert code == 0, output
    # with the launch files that those include
    files = [line for line in output.splitlines() if not line.startswith('[run] ')]
    assert [line for line in files if not line.startswith(checkout + os.sep)] == []
    assert {name for _, name in commands} <= {os.path.basename(line) for line in files}


# Installation

APT = """#!/bin/sh
echo "apt-get $*" >>{log}
case "$*" in
  install*)
    [ -z "$APT_ERROR" ] || {{ echo "$APT_ERROR" >&2; exit 100; }}
    echo Setting up shellcheck ;;
esac
"""


@pytest.fixture
def bare(checkout, env, tmp_path):
    """The environment of a machine whose packages are missing, and a log of the calls of apt."""
    log = tmp_path / 'apt.log'
    log.write_text('')
    (tmp_path / 'bin').mkdir()
    env = dict(env, PATH='{}:{}'.format(tmp_path / 'bin', env['PATH']))
    add_program(env, 'apt-get', APT.format(log=log))
    add_program(env, 'sudo', 'echo sudo >>{}\nexec "$@" 3>&-\n'.format(log))
    add_program(env, 'dpkg-query', '')
    return env, log


def add_program(env, name, text):
    """Put a program before all others."""
    path = os.path.join(env['PATH'].split(os.pathsep)[0], name)
    with open(path, 'w') as file:
        file.write('#!/bin/sh\n' + text)
    os.chmod(path, 0o755)


def in_terminal(checkout, env, answer, *words):
    """Run ./run in a terminal, answer its question, and return its exit code and output."""
    master, terminal = pty.openpty()
    process = subprocess.Popen(['./run', *words], cwd=checkout, env=env, stdin=terminal,
                               stdout=terminal, stderr=terminal)
    os.close(terminal)
    output, end = '', time.monotonic() + DEADLINE_S * stretch()
    while time.monotonic() < end:
        if select.select([master], [], [], 0.1)[0]:
            try:
                output += os.read(master, 4096).decode(errors='replace')
            except OSError:         # end of the terminal
                break
        if answer and '[Y/n]' in output:
            os.write(master, answer.encode())
            answer = ''
    os.close(master)
    return process.wait(), output


def installs(log):
    return [line for line in log.read_text().splitlines() if line.startswith('apt-get install')]


def test_without_a_terminal_it_does_not_ask_and_the_output_is_in_the_log(checkout, bare):
    env, log = bare
    code, output = run(checkout, env, 'setup')
    assert code == 0 and '[Y/n]' not in output, output
    assert output.endswith(
        '[run] setup is done; start the demo with ./run demo, which builds first\n')
    assert re.search(r'\d+ system packages of packages-\w+\.txt are missing: .*cmake', output)
    assert len(installs(log)) == 1 and 'Setting up' not in output
    with open(os.path.join(checkout, 'build', 'apt.log')) as file:
        assert 'Setting up shellcheck' in file.read()


@pytest.mark.parametrize('answer, expected', [('\n', 1), ('y\n', 1), ('n\n', 0)])
def test_in_a_terminal_it_asks_who_is_not_root_before_sudo_is_called(
        checkout, bare, answer, expected):
    env, log = bare
    add_program(env, 'id', 'echo 1000\n')
    code, output = in_terminal(checkout, env, answer, 'setup')
    assert ' cmake ' in output.partition('Install these? [Y/n]')[0], output
    assert len(installs(log)) == expected and ('sudo' in log.read_text()) == bool(expected)
    assert code == 1 - expected, output
    assert ('nothing installed', 'Setting up shellcheck')[expected] in output


@pytest.mark.parametrize('words, ci', [(('-y', 'setup'), ''), (('setup', '--yes'), ''),
                                       (('setup',), 'true')])
def test_yes_option_and_ci_skip_the_question(checkout, bare, words, ci):
    env, log = bare
    code, output = in_terminal(checkout, dict(env, CI=ci), '', *words)
    assert '[Y/n]' not in output and code == 0, output
    assert len(installs(log)) == 1


def test_without_sudo_the_packages_for_the_administrator_are_named(checkout, bare, tmp_path):
    env, log = bare
    add_program(env, 'id', 'echo 1000\n')
    os.remove(str(tmp_path / 'bin' / 'sudo'))
    for folder in env['PATH'].split(os.pathsep)[1:]:
        if os.path.exists(os.path.join(folder, 'sudo')):
            pytest.skip('sudo is installed here')
    code, output = run(checkout, env, 'setup')
    assert code == 1 and log.read_text() == ''
    assert re.search(r'\[run\] system packages are missing, and there is no sudo: have the '
                     r'administrator run: apt-get install --no-install-recommends [-\w+. ]*cmake '
                     r'[-\w+. ]*\n$', output), output


def test_the_reason_of_a_program_that_fails_is_shown(checkout, bare):
    env, _ = bare
    add_program(env, 'id', 'echo 0\n')          # other users get advice, too
    reason = 'E: You don\'t have enough free space in /var/cache/apt/archives/'
    in_advance = '[run] apt-get failed: {}; see build/apt.log\n'.format(reason)
    code, output = run(checkout, dict(env, APT_ERROR=reason + '.'), 'setup')
    assert code == 1 and output.endswith(in_advance), output
    add_program(env, 'df', 'echo 0\n')          # the log could not be written
    code, output = run(checkout, dict(env, APT_ERROR='dpkg: error'), 'setup')
    assert code == 1 and 'apt-get failed: No space left on device; see build/' in output, output
    add_program(env, 'df', 'echo 1\n')
    code, output = run(checkout, env, 'build')  # cmake is configured, also if no test was before
    assert code == 0, output
    add_program(env, 'cmake', 'echo "CMake Error at a.txt:1 (include):"\n'
                'echo "  No space left on device"\necho\necho "-- incomplete"\nexit 1\n')
    code, output = run(checkout, env, 'build')
    assert code == 1, output
    assert re.search(r'\[run\] the build failed: No space left on device; see build/make.log\n$',
                     output), output


@pytest.mark.parametrize('word, program, text', [
    ('doc', 'doc/build', '#!/bin/sh\necho begins\n'),
    ('lint', 'tools/testing.py', 'print("begins")\n')])
def test_a_slow_command_says_at_its_start_how_long_it_takes(env, tmp_path, word, program, text):
    checkout = copied(tmp_path)
    write(checkout, program, text)
    os.chmod(os.path.join(checkout, program), 0o755)
    code, output = run(checkout, env, word)
    assert code == 0 and re.search(r'\[run\] .*, about 1 min\nbegins\n$', output), output


# Without internet

# downloads that package alone; all else is done by the real apt-get, but only simulated
OFFLINE_APT = """
case "$*" in
  "update "*Dir::State::lists=*/download_lists*) touch build/download_lists/all; exit ;;
  *--download-only*)
    [ -e build/download_lists/all ] || {{ echo 'E: Unable to locate package'; exit 100; }}
    for each; do case $each in Dir::Cache::archives=*) cp {deb} "${{each#*=}}" ;; esac; done ;;
  "update "*) exec /usr/bin/apt-get "$@" ;;
  *) exec /usr/bin/apt-get -s "$@" ;;
esac
"""


@pytest.fixture
def tiny(env, tmp_path):
    """A copy whose lists name a package and a wheel that are only here, and an environment."""
    checkout = copied(tmp_path)
    os.unlink(os.path.join(checkout, '.venv'))      # that of all others
    control = tmp_path / 'deb' / 'DEBIAN' / 'control'
    control.parent.mkdir(parents=True)
    control.write_text('Package: img-recog-tiny\nVersion: 1.0\nArchitecture: all\n'
                       'Maintainer: nobody\nDescription: a test\n')
    subprocess.run(['dpkg-deb', '-b', str(tmp_path / 'deb'), str(tmp_path / 'tiny_1.0_all.deb')],
                   check=True, stdout=subprocess.DEVNULL)
    for name in ('packages-debian.txt', 'packages-noetic.txt'):
        write(checkout, name, 'img-recog-tiny\n')
    path = tmp_path / 'img_recog_tiny-1.0-py3-none-any.whl'
    with zipfile.ZipFile(str(path), 'w') as wheel:
        info = 'img_recog_tiny-1.0.dist-info/'
        wheel.writestr('img_recog_tiny.py', '')
        wheel.writestr(info + 'METADATA', 'Metadata-Version: 2.1\nName: img_recog_tiny\n'
                       'Version: 1.0\n')
        wheel.writestr(info + 'WHEEL', 'Wheel-Version: 1.0\nRoot-Is-Purelib: true\n'
                       'Tag: py3-none-any\n')
        wheel.writestr(info + 'RECORD', '')
    for lock in glob.glob(os.path.join(checkout, 'requirements', '3.*')):
        write(checkout, lock, 'img_recog_tiny==1.0 --hash=sha256:{}\n'.format(
            hashlib.sha256(path.read_bytes()).hexdigest()))
    (tmp_path / 'bin').mkdir()
    env = dict(env, PATH='{}:{}'.format(tmp_path / 'bin', env['PATH']))
    add_program(env, 'apt-get', OFFLINE_APT.format(deb=tmp_path / 'tiny_1.0_all.deb'))
    add_program(env, 'sudo', 'exec "$@"\n')
    return checkout, env


def download(checkout, env, folder):
    """Run `./run setup --download` without setup, to which no source of apt offers the package."""
    done = subprocess.run(
        ['bash', '-ec', 'root=$PWD build=$PWD/build python=/usr/bin/python3 noetic=/none '
         'venv=$PWD/.venv; . tools/messages.bash; . tools/packages.bash; mkdir -p build; '
         'setup() { has_venv || make_venv; }; download "$0"', str(folder)],
        cwd=checkout, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    return done.returncode, done.stdout.decode()


def test_what_is_downloaded_is_enough_to_install_without_internet(tiny, tmp_path):
    checkout, env = tiny
    folder = tmp_path / 'USB disk, 50% [full]'
    code, output = download(
        checkout, dict(env, PIP_NO_INDEX='1', PIP_FIND_LINKS=str(tmp_path)), folder)
    assert code == 0, output
    shutil.rmtree(os.path.join(checkout, '.venv'))
    code, output = run(checkout, env, 'setup', '--from', str(folder))
    assert code == 0, output
    with open(os.path.join(checkout, 'build', 'apt.log')) as file:
        assert re.search(r'(?m)^Inst img-recog-tiny \(1.0 ', file.read())
    subprocess.run([os.path.join(checkout, '.venv', 'bin', 'python3'), '-c',
                    'import img_recog_tiny'], check=True)
    (folder / 'platform').write_text('debian 11 riscv64\n')
    code, output = run(checkout, env, 'setup', '--from', str(folder))
    assert code == 1 and ' is for debian 11 riscv64, and this computer is ' in output, output


def test_a_download_needs_no_root_rights(tiny, tmp_path):
    checkout, env = tiny
    add_program(env, 'id', 'echo 1000\n')
    add_program(env, 'sudo', 'exit 1\n')
    folder = tmp_path / 'disk'
    code, output = download(
        checkout, dict(env, PIP_NO_INDEX='1', PIP_FIND_LINKS=str(tmp_path)), folder)
    assert code == 0 and (folder / 'packages' / 'tiny_1.0_all.deb').exists(), output


CHANGED = (r'\[run\] pip failed: img_recog_tiny==1\.0 from \S+{}\S*/img_recog_tiny-1\.0-\S+; '
           r'it was changed on the way, since requirements/ has another hash: get it from another '
           r'source; see build/{}\n$')


def test_a_package_that_was_changed_on_the_way_is_refused(tiny, tmp_path):
    checkout, env = tiny
    wheel, folder = tmp_path / 'img_recog_tiny-1.0-py3-none-any.whl', tmp_path / 'disk'
    with_wheel = dict(env, PIP_NO_INDEX='1', PIP_FIND_LINKS=str(tmp_path))
    code, output = download(checkout, with_wheel, folder)
    assert code == 0, output
    with zipfile.ZipFile(str(wheel), 'a') as file:
        file.writestr('other.py', 'print("not what was released")\n')
    code, output = download(checkout, with_wheel, tmp_path / 'other')
    assert code == 1 and re.search(CHANGED.format(tmp_path.name, 'wheels.log'), output), output
    shutil.copy(str(wheel), str(folder / 'wheels'))
    shutil.rmtree(os.path.join(checkout, '.venv'))
    code, output = run(checkout, env, 'setup', '--from', str(folder))
    assert code == 1 and re.search(CHANGED.format(
        '(?:disk|build/offline)/wheels', 'pip.log'), output), output     # pip 25 names the link
    code, output = download(checkout, with_wheel, folder)       # its setup
    assert code == 1 and re.search(CHANGED.format(tmp_path.name, 'pip.log'), output), output


def test_the_environment_of_another_clone_is_left_as_it_is(tiny, tmp_path):
    checkout, env = tiny
    other = tmp_path / 'other clone'
    other.mkdir()
    (other / 'lock.txt').write_text('another\n')
    venv = os.path.join(checkout, '.venv')
    os.symlink(str(other), venv)
    code, output = download(
        checkout, dict(env, PIP_NO_INDEX='1', PIP_FIND_LINKS=str(tmp_path)), tmp_path / 'disk')
    assert code == 0 and not os.path.islink(venv), output
    assert [path.name for path in other.iterdir()] == ['lock.txt']


def test_each_lock_file_names_all_packages_with_hashes_and_no_index():
    wanted = re.findall(r'(?m)^([\w-]+)==([\w.]+)(?:; python_version (<|>=) "3.(\d+)")?$',
                        read('requirements.txt'))
    assert len(wanted) > 6
    for version in (8, 11, 13):
        lock = read('requirements/3.{}.txt'.format(version))
        assert not re.search(r'://|index|find-links', lock)
        entries = dict(re.findall(r'(?m)^([a-z0-9-]+)==(\S+) \\\n    --hash=sha256:\w{64}', lock))
        assert len(entries) == len(re.findall(r'(?m)^[^ #]', lock)) > 40
        for name, number, sign, minor in wanted:
            is_meant = not sign or (version < int(minor)) == (sign == '<')
            assert not is_meant or entries[name] == number, name
        system = re.findall(r'(?m)^([a-z]+)==.* == "3.{}"$'.format(version),
                            read('requirements/system.txt'))
        assert system and not set(system) & set(entries)


def test_it_says_in_advance_that_pybullet_is_compiled(tiny, tmp_path):
    checkout, env = tiny
    env = dict(env, PIP_NO_INDEX='1', PIP_FIND_LINKS=str(tmp_path))
    expected = '[run] PyBullet is compiled, because it has no wheel for this system: 7 minutes'
    for machine, is_expected in (('aarch64', True), ('x86_64', sys.version_info >= (3, 12))):
        add_program(env, 'uname', 'echo {}\n'.format(machine))
        code, output = download(checkout, env, tmp_path / 'disk')
        assert code == 0 and (expected in output) == is_expected, output
        shutil.rmtree(os.path.join(checkout, '.venv'))


# Japanese

def test_messages_are_in_japanese_if_lang_says_so(checkout, bare):
    env, _ = bare
    code, output = run(checkout, dict(env, LANG='ja_JP.UTF-8'), 'setup')
    assert '[run] セットアップが完了しました。' in output.splitlines()[-1]
    assert code == 0 and re.search(r'システムパッケージ \d+ 個 \(packages-\w+.txt に記載\)', output)
    code, output = run(checkout, dict(env, LANG='ja_JP.UTF-8'), 'demo', 'cameras:=auto')
    assert code == 1 and '[run] demo.launch に引数 cameras はありません。camera の間違い' in output
    commands = [re.findall(r'(?m)^  (\S.{22})', run(checkout, dict(env, LANG=lang), 'help')[1])
                for lang in ('C', 'ja_JP.UTF-8')]
    assert commands[0] == commands[1] and len(commands[0]) > 10
    # the first of the variables that is set
    code, output = run(checkout, dict(env, LANG='ja_JP.UTF-8', LC_ALL='C.UTF-8'), 'x{}y')
    assert code == 1 and output.endswith('[run] unknown command x{}y\n'), output
