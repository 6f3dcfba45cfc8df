"""The start of programs."""
import subprocess
import sys

import pytest

PROGRAM = '''import sys, types
from img_recog.command_line import programs
from img_recog.processes import script
def program(words, interrupts):
    programs.keep_for_data()
    sys.stderr.write('a warning')
    programs.write('data')
    return ''
sys.modules['module'] = types.SimpleNamespace(
    main=lambda: programs.run('a.py', program, 'cannot write', []))
script.start('module')'''


@pytest.mark.parametrize('closed, code, out, err', [
    ('2>&-', 0, 'data\n', ''),
    ('<&- 2>&-', 0, 'data\n', ''),
    ('>&-', 1, '', 'a warninga.py: error: cannot write: Bad file descriptor\n'),
    ('>&- 2>&-', 1, '', '')])
def test_streams_that_are_closed(closed, code, out, err):
    done = subprocess.run(['sh', '-c', 'exec "$@" ' + closed, 'sh', sys.executable, '-c', PROGRAM],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    assert (done.returncode, done.stdout, done.stderr) == (code, out, err)
