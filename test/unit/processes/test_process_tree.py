"""The descendants of a process, also those whose parents have ended."""
import concurrent.futures
import fcntl
import io
import multiprocessing
import os
import pty
import signal
import subprocess
import sys
import termios

import pytest

from img_recog.processes import process_tree
from img_recog_helpers.waiting import DEADLINE_S


def in_fork(function, *args):
    """Return what a function returns in a fork of this process: it may adopt orphans."""
    context = multiprocessing.get_context('fork')
    with concurrent.futures.ProcessPoolExecutor(1, context) as pool:
        return pool.submit(function, *args).result(DEADLINE_S)


def fork(run):
    """Run a function in a child; return the id."""
    pid = os.fork()
    if pid == 0:
        try:
            run()
        finally:
            os._exit(3)
    return pid


def family(folder):
    """Make children and grandchildren and end them; return what is found of them."""
    # the name of the process is cut after 15 bytes, within a character
    program = os.path.join(folder, 'a) Z 1 (bbbbbbé')
    os.symlink('/bin/sleep', program)
    reader, writer = os.pipe()

    def parent():
        for _ in range(2):
            os.write(writer, b'%d ' % subprocess.Popen([program, '60']).pid)
        signal.pause()
    child = fork(parent)
    process_tree.adopt_orphans()
    ids = b''
    while ids.count(b' ') < 2:
        ids += os.read(reader, 99)
    grandchildren = list(map(int, ids.split()))
    running = os.listdir('/proc')
    os.listdir = lambda _: ['1' * 9, *running]      # one of them has ended meanwhile
    found = [process_tree.descendants() == [child, *grandchildren], process_tree.reap() == {}]
    process_tree.send(signal.SIGKILL, [child])
    os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
    # a child whose exit code nobody has asked for is no descendant, and orphans are ours
    found += [process_tree.descendants() == grandchildren,
              process_tree.reap() == {child: -signal.SIGKILL}]
    process_tree.send(signal.SIGTERM, [child, *grandchildren])
    for pid in grandchildren:
        os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    return found + [process_tree.reap() == dict.fromkeys(grandchildren, -signal.SIGTERM),
                    process_tree.reap() == {}]


def test_children_grandchildren_and_orphans(tmp_path):
    assert in_fork(family, str(tmp_path)) == [True] * 6


def orphan():
    """Return how a child and a grandchild end that shall end with its parent."""
    process_tree.adopt_orphans()
    reader, writer = os.pipe()

    def grandchild():
        process_tree.end_with_parent()
        os.write(writer, b'%d' % os.getpid())
        signal.sigtimedwait([], DEADLINE_S)

    def parent():
        os.read(reader, 99)
    child = fork(lambda: (fork(grandchild), parent()))
    codes = {}
    while len(codes) < 2:
        codes.update(process_tree.reap())
    return codes.pop(child), *codes.values()


def test_the_kernel_ends_a_process_with_its_parent():
    assert in_fork(orphan) == (3, -signal.SIGTERM)


def test_what_the_kernel_refuses_is_an_error(monkeypatch):
    monkeypatch.setattr(process_tree, 'PR_SET_PDEATHSIG', -1)
    with pytest.raises(OSError, match=r'^\[Errno 22\] prctl$'):
        process_tree.end_with_parent()


def test_a_process_that_does_not_end_in_time_is_killed():
    with subprocess.Popen(['sleep', '60']) as hangs, subprocess.Popen(['true']) as ends:
        process_tree.wait_or_kill(hangs, 0.01)
        process_tree.wait_or_kill(ends, DEADLINE_S)
        assert (hangs.returncode, ends.returncode) == (-signal.SIGKILL, 0)


def answer(terminal, folder, in_background):
    """Have a program ask in_foreground(stdin) in a session of its own, as a node of roslaunch.

    The program that starts it has the terminal, and is in its foreground unless `in_background`.
    """
    def have_terminal():
        os.setsid()
        fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)
        if in_background:
            if os.fork():
                os.wait()
                os._exit(0)
            os.setpgid(0, 0)        # like a job that a shell starts with &
    node = ('import sys; from img_recog.processes.process_tree import in_foreground; '
            'print(in_foreground(sys.stdin))')
    starter = ('import subprocess, sys; subprocess.check_call([sys.executable, "-c", {!r}], '
               'start_new_session=True)'.format(node))
    path = os.path.join(folder, 'answer')
    with open(path, 'w') as file:
        subprocess.run([sys.executable, '-c', starter], stdin=terminal, stdout=file, check=True,
                       preexec_fn=have_terminal)
    with open(path) as file:
        return file.read()


@pytest.mark.parametrize('in_background', [False, True])
def test_what_a_program_of_the_foreground_starts_is_in_it(tmp_path, in_background):
    master, slave = pty.openpty()
    try:
        assert answer(slave, str(tmp_path), in_background) == '{}\n'.format(not in_background)
    finally:
        os.close(master)
        os.close(slave)


def test_no_stream_that_is_no_terminal_has_a_foreground(tmp_path):
    (tmp_path / 'keys').write_text('w')
    with open(str(tmp_path / 'keys')) as file:
        assert process_tree.in_foreground(file) is False
    for stream in (file, None, object(), io.StringIO('w')):
        assert process_tree.in_foreground(stream) is False
    master, slave = pty.openpty()       # no session has it
    with open(slave, 'rb', buffering=0) as terminal:
        assert process_tree.in_foreground(terminal) is False
    os.close(master)
