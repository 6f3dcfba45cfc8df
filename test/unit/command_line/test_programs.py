"""What all programs have in common."""
import os
import signal
import subprocess
import sys

import pytest

from img_recog.command_line import programs
from img_recog.errors import UserError


@pytest.fixture
def run(caplog, capsys, handlers_as_before):
    """A function that runs a program; it returns the exit code, the output and the log."""
    def run(program, *words):
        code = programs.run('program', program, 'cannot do it', words)
        return code, capsys.readouterr().out, caplog.messages
    return run


def test_only_the_names_that_roslaunch_adds_are_left_out(run):
    words = 'a.bag', '__name:=replay', 'b:=c', '__d', '__log:=/tmp/log'
    assert run(lambda left, _: ' '.join(left), *words) == (0, 'a.bag b:=c __d\n', [])


@pytest.mark.parametrize('error, line, code', [
    (UserError('no\nbag', 'give one'), 'no bag; give one', 1),
    (OSError(28, 'No space left on device', 'out.mp4'), 'out.mp4: No space left on device', 1),
    (OSError(28, 'No space left on device'), 'cannot do it: No space left on device', 1),
    (KeyboardInterrupt(), None, 130)])
def test_what_ends_a_program_is_one_line(run, error, line, code):
    def program(*_):
        raise error
    assert run(program) == (code, '', [line] if line else [])


def test_a_crash_has_a_line_with_the_words_of_the_command():
    crashed = subprocess.run([
        sys.executable, '-c', 'import faulthandler\nfrom img_recog.command_line import programs\n'
        'programs.run("replay.py", lambda *_: faulthandler._sigsegv(), "", ["a.flv"])'],
        stderr=subprocess.PIPE, universal_newlines=True)
    assert crashed.returncode == -signal.SIGSEGV and '<replay.py a.flv>' in crashed.stderr


PRINTS = '''import ctypes, os
from img_recog.command_line import programs
def program(words, interrupts):
    programs.keep_for_data()
    print('by Python')
    os.write(1, b'by the system\\n')
    ctypes.CDLL(None).puts(b'by C')
    os.system('echo by a child')
    programs.write('data')
    return 'summary'
raise SystemExit(programs.run('a.py', program, '', []))'''


@pytest.mark.parametrize('redirection', ['', '2>&-'])
def test_nothing_but_data_is_written_to_stdout(redirection):
    done = subprocess.run(
        ['bash', '-c', '"$0" -c "$1" ' + redirection, sys.executable, PRINTS],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    assert (done.returncode, done.stdout) == (0, 'data\nsummary\n'), done
    assert sorted(done.stderr.splitlines()) == ([] if redirection else [
        'by C', 'by Python', 'by a child', 'by the system'])


@pytest.mark.parametrize('closed, code, wanted', [
    ((), 0, 0), (('stdout',), 0, 1), (('stderr',), 0, 1), (('stdout',), 1, 1), ((), 1, 1)])
def test_exit_code_when_nobody_reads_the_output(monkeypatch, closed, code, wanted):
    def program(words, interrupts):
        sys.stderr.write('the last line\n')
        return programs.Incomplete('the last line') if code else 'the last line'
    ends = {name: os.pipe() for name in ('stdout', 'stderr')}
    with monkeypatch.context() as patched:
        for name, (read, write) in ends.items():
            patched.setattr(sys, name, os.fdopen(write, 'w'))
            if name in closed:
                os.close(read)
        assert programs.run('a.py', program, '', []) == wanted
        # Python does so once more at its end
        sys.stdout.close()
        sys.stderr.close()
    for name in ends.keys() - set(closed):
        with os.fdopen(ends[name][0]) as stream:
            assert stream.read() == 'the last line\n'
