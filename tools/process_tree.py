"""Every process that comes from this one, also those whose parents have ended."""
import ctypes
import os
import signal

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36


def adopt_orphans():
    """Become the parent of descendants whose own parent ends, as init is otherwise.

    roslaunch starts each node in a session of its own: without this nothing would lead from here
    to the nodes of a roslaunch that was killed.
    """
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def end_with_parent():
    """Have the kernel send this process SIGTERM when its parent ends, also if that is killed."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def _prctl(option, value):
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(option, ctypes.c_ulong(value), 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), 'prctl')


def descendants():
    """Return the ids of all processes below this one, the youngest generation last."""
    children = {}
    for name in filter(str.isdigit, os.listdir('/proc')):
        try:
            with open('/proc/{}/stat'.format(name)) as file:
                # PID (NAME) STATE PARENT ..., and the name may hold spaces and brackets
                state, parent = file.read().rpartition(')')[2].split()[:2]
        except OSError:         # it has ended meanwhile
            continue
        if state not in 'ZX':
            children.setdefault(int(parent), []).append(int(name))
    found, generation = [], [os.getpid()]
    while generation:
        generation = [child for pid in generation for child in children.get(pid, ())]
        found += generation
    return found


def send(signum, pids):
    """Send a signal to those of the processes that are still there."""
    for pid in pids:
        try:
            os.kill(pid, signum)
        except ProcessLookupError:
            pass


def reap():
    """Take the exit codes of all children that have ended; return them by process id."""
    codes = {}
    while True:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return codes
        if pid == 0:
            return codes
        codes[pid] = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
