"""What is left of the output of the demo while the disk of the log is full."""
import subprocess
import sys

import pytest

from img_recog_helpers.pages import tool

BEFORE, BETWEEN = b'[INFO] one\n', b'[INFO] two, from another node\n'
ROSOUT = b"Error flushing rosout log file '/home/me/log/rosout.log': No space left on device"


def logged(error):
    """Return what logging prints for two lines that it cannot write."""
    code = ('import logging, sys\n'
            'class Handler(logging.StreamHandler):\n'
            '    def flush(self):\n'
            '        raise {}\n'
            'logging.getLogger().addHandler(Handler(sys.stdout))\n'
            'logging.error("a %s", 1)\nlogging.error("b")\n').format(error)
    output = subprocess.run([sys.executable, '-c', code], stderr=subprocess.PIPE, check=True)
    assert output.stderr.count(b'--- Logging error ---\n') == 2
    return output.stderr


@pytest.fixture(params=[1, 7, 100000])
def passed(request):
    """A function that returns what is left of an output that comes in pieces, and the filter."""
    def run(output):
        disk = tool('full_disk').FullDiskFilter()
        pieces = [output[begin:begin + request.param]
                  for begin in range(0, len(output), request.param)]
        return b''.join(disk.passed(piece) for piece in [*pieces, b'']), disk
    return run


@pytest.mark.parametrize('error', ['28, "full"', '122, "full", "a.log"'])
def test_errors_of_a_full_disk_are_removed(passed, error):
    errors = logged('OSError({})'.format(error))
    first, _, rest = errors.partition(b'Call stack:\n')
    output = BEFORE + first + BETWEEN + b'Call stack:\n' + rest + b'the end'
    assert passed(output)[0] == BEFORE + BETWEEN + b'the end'
    assert passed(output)[1].reason == 'full'


def test_errors_of_two_processes_that_print_at_the_same_time_are_removed(passed):
    error = logged('OSError(28, "full")')
    output = BEFORE + BETWEEN[:-1] + b''.join(
        b'\n'.join(pair) + b'\n' for pair in zip(*2 * [error.splitlines()])) + BETWEEN
    # the end of a line that was already passed is lost
    assert passed(output)[0].replace(b'\n', b'') == (BEFORE + 2 * BETWEEN).replace(b'\n', b'')


def test_errors_of_rosout_are_removed(passed):
    left, disk = passed(BEFORE + 3 * ROSOUT + BETWEEN + ROSOUT)
    assert left == BEFORE + BETWEEN and disk.reason == 'No space left on device'


@pytest.mark.parametrize('output', [
    logged('OSError(1, "broken")'), logged('ValueError("no")'), b'Traceback (most recent call '
    b'last):\n  File "a"\nOSError: [Errno 28] full\n', b'--- Logging error ---\nno more',
    b'--- \n-', b'Error flushing', b'a\n\nb'])
def test_all_else_is_left(passed, output):
    left, disk = passed(BEFORE + output)
    assert left == BEFORE + output and not disk.reason


def test_a_partial_line_does_not_wait():
    disk = tool('full_disk').FullDiskFilter()
    assert [disk.passed(data) for data in (b'name? ', b'x', b'\n- ', b'y')] == [
        b'name? ', b'x', b'\n- ', b'y']
