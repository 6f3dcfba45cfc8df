#!/usr/bin/env python3
"""The linters and tests of ./run.

usage: testing.py lint | test [--accept] [unit] [rostest] [system] [-k NAME]

With --accept, texts that programs print and that differ from those in test/expected/ replace them;
see what has changed by git diff.
"""
import glob
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.path.join(ROOT, 'build')
CMAKE = os.path.join(BUILD, '.cmake')
RESULTS = os.path.join(BUILD, 'test_results')
LOG = os.path.join(BUILD, 'test.log')
KINDS = 'unit', 'rostest', 'system'
PURE = ('camera', 'conversions', 'formats', 'recognition', 'rendering', 'simulation',
        'teleoperation')
NOT_OURS = {'.git', '.venv', 'build', 'devel', '__pycache__'}
# of what make prints: a line for each test, without the log of the nodes
_SHOWN = re.compile(r'\[img_recog\.|\[Testcase|[.FEsx]+ +\[|FAILED|E  |.*(passed|failed|RESULT)')
_MAX_REPEATED = 5
# of the tests: they expect texts in this language
_env = {**os.environ, 'LC_ALL': 'C.UTF-8', 'COVERAGE_FILE': os.path.join(BUILD, 'coverage.data')}
sys.path.insert(0, os.path.join(ROOT, 'src'))
from img_recog.command_line.messages import message     # noqa: E402


def say(text, *values):
    """Print a line in the language of the user."""
    print('[run] ' + message(text, *values), flush=True)


# Linters

def lint():
    """Print a line for each linter, and its output if it reports anything; return the code."""
    commands = {'flake8': [*_uncollected('flake8'), '.'],
                'mypy': [*_uncollected('mypy'), *_mypy_settings()],
                'catkin_lint': ['catkin_lint', '-q', '-W2', '--strict', '--ignore',
                                'package_path_name', ROOT],
                'shellcheck': ['shellcheck', *_shell_scripts()]}
    version = _output([sys.executable, '-m', 'mypy', '--version'])[1]
    numbers = [int(each) for each in re.findall(r'\d+', version)[:2]]
    # earlier ones (Ubuntu 20.04 has 0.761) report errors in code that later ones accept
    if numbers < [0, 990]:
        say('mypy: not run, {} is older than 0.990', '.'.join(map(str, numbers)) or '?')
        del commands['mypy']
    verdict = 0
    for name, command in commands.items():
        code, output = _output(command)
        # mypy keeps nothing of a module with a note, nor of those that import it, for the next run
        if code or ': note: ' in output:
            verdict = 1
            print('[run] {}:\n{}'.format(name, output.rstrip()), flush=True)
        else:
            say('{}: clean', name)
    return verdict


def _mypy_settings():
    """Return mypy's option for settings that fit the libraries of this machine.

    The types of numpy 2 contradict those of numpy 1, which the reference machine has; so do those
    of the PyAV and moderngl of the same distributions. mypy takes them for unknown types.
    """
    import numpy
    if int(numpy.__version__.partition('.')[0]) < 2:
        return []
    path = os.path.join(BUILD, 'mypy.cfg')
    with open(os.path.join(ROOT, 'setup.cfg')) as settings, open(path, 'w') as file:
        file.write(settings.read() +
                   '\n[mypy-av.*,moderngl.*,numpy.*]\nfollow_imports = skip\n'
                   'follow_imports_for_stubs = True\n')
    return ['--config-file', path]


def _uncollected(linter):
    """Return the command of a linter without garbage collection: that takes a third of the time,
    and finds little.
    """
    return [sys.executable, '-c', 'import gc, runpy; gc.disable(); '
            'runpy.run_module("{}", run_name="__main__", alter_sys=True)'.format(linter)]


def _output(command):
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env=_env, universal_newlines=True, check=False)
    return done.returncode, done.stdout


def _shell_scripts():
    for folder, folders, names in os.walk(ROOT):
        folders[:] = sorted(set(folders) - NOT_OURS)
        for name in sorted(names):
            path = os.path.join(folder, name)
            if not name.endswith('.py') and os.path.isfile(path):
                with open(path, 'rb') as file:
                    if re.search(rb'^#!.*\b(ba)?sh$|^# shellcheck shell=', file.read(), re.M):
                        yield os.path.relpath(path, ROOT)


# Tests

def test(words):
    """Run the tests that the words select; return the exit code."""
    kinds, expression, words = [], '', list(words)
    while words:
        word = words.pop(0)
        if word in KINDS:
            kinds.append(word)
        elif word == '--accept':
            _env['IMG_RECOG_ACCEPT'] = '1'
        elif word == '-k' and words:
            expression = words.pop(0)
        else:
            return (refused('-k needs a name') if word == '-k' else refused(
                'test takes unit, rostest or system, -k NAME and --accept; got {}', word))
    shutil.rmtree(RESULTS, ignore_errors=True)
    for path in (os.path.join(BUILD, 'coverage.data'), LOG):
        if os.path.exists(path):
            os.remove(path)
    # the tests start hundreds of processes, which otherwise compile every module again
    _env.pop('PYTHONDONTWRITEBYTECODE', None)
    codes = []
    if kinds or expression:
        code, text = _output(['cmake', '--build', CMAKE, '--target', 'tests'])
        if code:
            sys.stderr.write(text)
            return code
        codes += [_run_kind(kind, expression) for kind in kinds or KINDS]
        if not glob.glob(os.path.join(RESULTS, '**', '*.xml'), recursive=True):
            return (refused('no test matches {}', expression) if not kinds else
                    refused('no test of {} matches {}', ' '.join(kinds), expression))
    else:
        codes += [_run_all()]
        _repeat_failed()
    _report_coverage()
    # the target run_tests succeeds even if tests fail; the result files decide
    codes += [subprocess.call(['catkin_test_results', RESULTS]), subprocess.call(_summary())]
    if any(codes):
        sys.stdout.flush()
        sys.stderr.write('[run] {}\n'.format(message(
            'failed; see {}', 'build/test_results' if kinds or expression else
            'build/test.log and build/test_results')))
    return next(filter(None, codes), 0)


def refused(text, *values):
    """Print a line about the words of the user; return the exit code."""
    sys.stderr.write('[run] {}\n'.format(message(text, *values)))
    return 1


def _summary(*options):
    return [sys.executable, os.path.join(ROOT, 'test', 'summary.py'), RESULTS, *options]


def _run_all():
    _keep_versions()
    # Most tests wait for a robot in real time, so several fit on two cores at the same time. Two
    # more than cores: with one more, a tenth of the time of two cores was left.
    jobs = min(4, len(os.sched_getaffinity(0)) + 2)
    say('running the tests, {} at a time, about 12 min; the full output is in build/test.log',
        jobs)
    return _make('run_tests', '-j', str(jobs))


def _make(target, *options):
    """Make a target; show a line for each test. Return the exit code."""
    with open(LOG, 'ab') as log, subprocess.Popen(
            ['cmake', '--build', CMAKE, '--target', target, '--', *options], env=_env,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as make:
        for line in make.stdout:
            log.write(line)
            text = line.decode(errors='replace').rstrip()
            if _SHOWN.match(text):
                print(text, flush=True)
    return make.returncode


def _repeat_failed():
    """Run files of tests with processes that have failed again, once.

    What fails beside other programs, and not alone, is no reason to reject a change. The first
    results stay in build/test.log.
    """
    targets = _output(_summary('--targets'))[1].split()
    kept = os.path.join(BUILD, 'kept_results')
    for target in targets if len(targets) <= _MAX_REPEATED else []:
        say('failed beside other tests, now runs again alone: {}', target)
        shutil.rmtree(kept, ignore_errors=True)
        os.rename(RESULTS, kept)        # the target removes the results of the others
        _make('_run_tests_img_recog_' + target)
        subprocess.run(['cp', '-rT', RESULTS, kept], check=True)
        shutil.rmtree(RESULTS)
        os.rename(kept, RESULTS)


def _keep_versions():
    """Keep what rosversion answers: each roslaunch asks it twice, and Python takes 0.1 s."""
    folder = os.path.join(BUILD, 'programs')
    os.makedirs(folder, exist_ok=True)
    answers = [_output(['rosversion', word])[1].strip() for word in ('roslaunch', '-d')]
    path = os.path.join(folder, 'rosversion')
    with open(path + '.new', 'w') as file:
        file.write('#!/bin/sh\ncase $* in\n  roslaunch) echo {} ;;\n  -d) echo {} ;;\n'
                   '  *) exec {} "$@" ;;\nesac\n'.format(*answers, shutil.which('rosversion')))
    os.chmod(path + '.new', 0o755)
    os.rename(path + '.new', path)
    _env['PATH'] = folder + os.pathsep + _env['PATH']


def _run_kind(kind, expression):
    """Run the tests of a kind whose names match; the results are where run_tests puts them."""
    results = os.path.join(RESULTS, 'img_recog')
    os.makedirs(results, exist_ok=True)
    if kind == 'rostest':
        files = sorted(glob.glob(os.path.join(ROOT, 'test', 'rostest', '*.test')))
        return max([0, *(subprocess.call([
            'rostest', '--pkgdir=' + ROOT, '--package=img_recog', '--results-base-dir=' + RESULTS,
            '--results-filename=test_rostest_{}.xml'.format(name), path], env=_env)
            for path in files for name in [os.path.basename(path)[:-len('.test')]]
            if expression in name)])
    xml = os.path.join(results, 'pytest-{}.xml'.format(kind))
    command, paths = [sys.executable], [os.path.join(ROOT, 'test', kind)]   # as in tests.cmake
    if kind == 'unit':
        # not when all tests run: it costs a third of the time of the unit tests
        command += ['-m', 'coverage', 'run', '--source=' + os.path.join(ROOT, 'src', 'img_recog')]
        # the examples in the docstrings; to import all other modules, too, takes seconds
        paths += ['--doctest-modules', *_output(
            ['grep', '-rl', '--include=*.py', '>>> ', os.path.join(ROOT, 'src')])[1].split()]
    code = subprocess.call(
        [*command, '-m', 'pytest', '-p', 'no:cacheprovider', '--timeout', '1200',
         '--junit-xml=' + xml, *(['-k', expression] if expression else []), *paths], env=_env)
    if code == 5:           # pytest: no tests were collected
        os.remove(xml)
        return 0
    return code


def _report_coverage():
    """Say how many lines of the pure folders the unit tests run."""
    data, path = os.path.join(BUILD, 'coverage.data'), os.path.join(BUILD, 'coverage.txt')
    if not os.path.exists(data):
        return
    include = ','.join(os.path.join(ROOT, 'src', 'img_recog', folder, '*') for folder in PURE)
    code, text = _output(
        [sys.executable, '-m', 'coverage', 'report', '-m', '--include=' + include])
    with open(path, 'w') as file:
        file.write(text)
    last = text.splitlines()[-1]
    if code:
        say('no coverage: {}', last)
    else:
        say('the unit tests run {} of the lines of {}; the others are listed in '
            'build/coverage.txt', last.split()[3], ' '.join(PURE))


if __name__ == '__main__':
    sys.exit(lint() if sys.argv[1] == 'lint' else test(sys.argv[2:]))
