"""scripts/respawn.py: which ends of a command are followed by a new start, and how it ends."""
import os
import signal
import subprocess
import sys

import pytest

from img_recog_helpers.process_table import is_alive
from img_recog_helpers.waiting import wait_for

FOLDER = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..',
                                       'scripts'))
PROGRAM = os.path.join(FOLDER, 'respawn.py')
# writes a line with its id, then runs the code that the test gives
NODE = '''
import os, signal, sys, time
with open(sys.argv[1], 'a') as file:
    file.write('{}\\n'.format(os.getpid()))
with open(sys.argv[1]) as file:
    starts = len(file.readlines())
def wait():
    while True:
        time.sleep(0.05)
'''
# calls respawn.py as roslaunch does, which also starts nodes in threads, and writes what it gets
PARENT = '''
import os, signal, subprocess, sys, threading
signal.signal(signal.SIGINT, lambda *_: print('interrupted', flush=True))
def start():
    global process
    process = subprocess.Popen(sys.argv[1:], start_new_session=True)
thread = threading.Thread(target=start)
thread.start()
thread.join()
while len(os.listdir('/proc/self/task')) > 1:       # the kernel signals its children before
    pass
print('child', process.pid, flush=True)
process.wait()
'''
# runs respawn.py after a change; roslaunch is killed while the node is started for the nth time
CHANGED = '''
import os, signal, subprocess, sys
sys.path.insert(0, {folder!r})
import respawn
starts = 0
class Popen(subprocess.Popen):
    def __init__(self, *args, **options):
        global starts
        starts += 1
        parent = os.getppid()
        if starts == {killed_at}:
            os.kill(parent, signal.SIGKILL)
        while starts == {killed_at} and os.getppid() == parent:
            pass
        super().__init__(*args, **options)
subprocess.Popen = Popen
respawn._END_LIMIT_S = {limit_s}
sys.exit(respawn.main())
'''


class Run:
    """respawn.py with a node."""

    def __init__(self, path, code, *options, arguments=(), program=(PROGRAM,)):
        self._starts = path / 'starts'
        self._errors = path / 'errors'
        command = [sys.executable, *program, *options, sys.executable, '-c', NODE + code,
                   str(self._starts), '__name:=node', *arguments]
        with open(str(self._errors), 'w') as file:
            self.process = subprocess.Popen([sys.executable, '-c', PARENT, *command], stderr=file,
                                            stdout=subprocess.PIPE, universal_newlines=True)
        self.pid = int(self.process.stdout.readline().split()[1])

    @property
    def pids(self):
        return list(map(int, self._starts.read_text().split())) if self._starts.exists() else []

    @property
    def errors(self):
        return self._errors.read_text()

    def wait_starts(self, count):
        wait_for(lambda: len(self.pids) >= count, lambda: '{} starts: {}'.format(
            count, self.errors))
        return self.pids[count - 1]

    def wait_errors(self, text):
        wait_for(lambda: text in self.errors, lambda: '{!r} in {!r}'.format(text, self.errors))

    def signal(self, signum):
        os.kill(self.pid, signum)
        self.process.wait()


@pytest.fixture
def run(tmp_path):
    """A function that starts respawn.py with the code of a node."""
    runs = []

    def start(code, *options, **more):
        runs.append(Run(tmp_path, code, *options, **more))
        return runs[-1]
    yield start
    for each in runs:
        if each.process.poll() is None:
            for pid in (each.pid, each.process.pid):
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            each.process.wait()
        each.process.stdout.close()


@pytest.mark.parametrize('end, reason', [
    ('os.kill(os.getpid(), signal.SIGKILL)', 'killed by SIGKILL'),
    ('os.kill(os.getpid(), signal.SIGSEGV)', 'killed by SIGSEGV'),
    ('sys.exit(70)', 'unexpected exception'), ('sys.exit(75)', 'no master answers'),
    ('sys.exit(77)', 'shut down from outside')])
def test_is_started_again(run, end, reason):
    process = run('if starts == 1: {}\nwait()'.format(end))
    process.wait_starts(2)
    assert process.errors == '[respawn] node: {}, started again\n'.format(reason)


@pytest.mark.parametrize('code, reason', [
    (0, 'it has finished'), (1, 'exit code 1'), (2, 'exit code 2'),
    (76, 'another node has taken its name')])
def test_is_not_started_again(run, code, reason):
    process = run('sys.exit({})'.format(code))
    process.wait_errors('again')
    assert process.errors == '[respawn] node: ended and is not started again: {}\n'.format(reason)
    assert len(process.pids) == 1 and is_alive(process.pid)     # or roslaunch would start it again
    process.signal(signal.SIGINT)
    assert len(process.pids) == 1


@pytest.mark.parametrize('code', ['wait()', 'sys.exit(70)'])
def test_it_and_its_node_do_not_outlive_roslaunch_that_is_killed(run, code):
    process = run(code)
    child = process.wait_starts(3 if 'exit' in code else 1)
    process.process.kill()
    wait_for(lambda: not is_alive(process.pid) and not is_alive(child), 'the end')
    assert not is_alive(process.pids[-1])


def test_it_does_not_outlive_roslaunch_that_is_killed_before_it_has_begun(run):
    process = run('wait()')
    process.process.kill()
    wait_for(lambda: not is_alive(process.pid), 'the end')
    assert not any(map(is_alive, process.pids))


@pytest.mark.parametrize('start', [1, 2])
def test_roslaunch_that_is_killed_while_the_node_is_started(run, start):
    process = run('if starts < {}: sys.exit(70)\nwait()'.format(start),
                  program=('-c', CHANGED.format(folder=FOLDER, killed_at=start, limit_s=15)))
    process.process.wait()
    wait_for(lambda: not is_alive(process.pid), 'the end')
    wait_for(lambda: not any(map(is_alive, process.pids)), 'the end of the node')


def test_a_node_that_does_not_end_is_killed_after_roslaunch(run):
    process = run('signal.signal(signal.SIGTERM, signal.SIG_IGN)\n'
                  'os.write(1, b"ready\\n")\nwait()',
                  program=('-c', CHANGED.format(folder=FOLDER, killed_at=0, limit_s=1)))
    assert process.process.stdout.readline() == 'ready\n'
    process.process.kill()
    wait_for(lambda: not is_alive(process.pid), 'the end')
    wait_for(lambda: not any(map(is_alive, process.pids)), 'the end of the node')


def test_it_does_not_outlive_roslaunch_when_the_node_has_ended(run):
    process = run('sys.exit(76)')
    process.wait_errors('again')
    process.process.kill()
    wait_for(lambda: not is_alive(process.pid), 'the end')


def test_the_reason_is_the_last_error_in_the_log_file(run, tmp_path):
    log = tmp_path / 'node.log'
    log.write_text('[rosout][ERROR] 2026-11-22 01:00:00,000: first\n'
                   '[rosout][CRITICAL] 2026-11-22 01:00:00,000: there is no file x\n'
                   '[rosout][INFO] 2026-11-22 01:00:00,000: more\n')
    process = run('sys.exit(1)', arguments=['__log:={}'.format(log)])
    process.wait_errors('not started again: there is no file x\n')


@pytest.mark.parametrize('code, options', [(1, ['--required']), (78, [])])
def test_a_required_node_or_a_refused_parameter_interrupts_roslaunch(run, code, options):
    process = run('sys.exit({})'.format(code), *options)
    assert process.process.stdout.readline() == 'interrupted\n'
    assert process.errors == '[respawn] node: ended, and the demo with it: exit code {}\n'.format(
        code)


def test_a_node_that_dies_at_once_again_is_started_later_and_later(run):
    process = run('sys.exit(70)')
    process.wait_starts(3)
    assert process.errors.startswith(''.join(
        '[respawn] node: unexpected exception, started again{}\n'.format(delay)
        for delay in ('', ' in 0.5 s')))


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_are_forwarded_once_and_end_it(run, signum):
    # not by print: the signal may come while it writes, and it cannot be called again then
    process = run('signal.signal({0}, lambda *_: (os.write(1, b"got it\\n"), sys.exit(0)))\n'
                  'os.write(1, b"ready\\n")\nwait()'.format(int(signum)))
    assert process.process.stdout.readline() == 'ready\n'
    os.killpg(process.pid, signum)          # as roslaunch does
    assert process.process.stdout.readline() == 'got it\n'
    process.process.wait()
    assert process.process.stdout.read() == '' and process.errors == ''
    assert len(process.pids) == 1


def test_the_node_does_not_outlive_it(run):
    process = run('wait()')
    child = process.wait_starts(1)
    process.signal(signal.SIGKILL)
    wait_for(lambda: not is_alive(child), 'the end of the node')


def test_without_a_command_it_prints_its_usage():
    result = subprocess.run([sys.executable, PROGRAM], stderr=subprocess.PIPE,
                            universal_newlines=True)
    assert result.returncode == 2 and result.stderr.startswith('usage: respawn.py')
