"""The processes of this machine, and what they use."""
import contextlib
import os
import signal
import socket
import time
from typing import Dict, List, NamedTuple, Set, Tuple

import psutil

from img_recog_helpers.waiting import wait_for

_LOOPBACK = ('127.0.0.1', '::1')


class Usage(NamedTuple):
    """What a process uses: numbers of threads and descriptors, resident memory in MB."""

    pid: int
    threads: int
    descriptors: int
    rss_mb: float


def usage(pid: int) -> Usage:
    """Return what a process uses; raises psutil.NoSuchProcess if it has ended."""
    process = psutil.Process(pid)
    return Usage(pid, process.num_threads(), process.num_fds(), process.memory_info().rss / 1e6)


def cpu_s(pid: int) -> float:
    """Return the CPU time of a process so far."""
    times = psutil.Process(pid).cpu_times()
    return times.user + times.system


def age_s(pid: int) -> float:
    """Return the seconds since a process was started."""
    return time.time() - psutil.Process(pid).create_time()


def is_alive(pid: int) -> bool:
    """Return whether a process runs; a zombie does not."""
    try:
        return psutil.Process(pid).status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    except psutil.NoSuchProcess:
        return False


def command_lines(processes) -> Dict[int, str]:
    """Return the command line of each process that has not ended, by its id."""
    found = {}
    for process in processes:
        with contextlib.suppress(psutil.Error):     # it has ended, or belongs to another user
            line = ' '.join(process.cmdline())
            if line:
                found[process.pid] = line
    return found


def descendants(pid: int) -> Dict[int, str]:
    """Return the command lines of all processes below a process."""
    try:
        return command_lines(psutil.Process(pid).children(recursive=True))
    except psutil.NoSuchProcess:
        return {}


def marked(marker: str) -> Dict[int, str]:
    """Return the command lines of the processes that have inherited an environment entry.

    marker: the entry, 'NAME=value'. Zombies do not count.
    """
    found = []
    for pid in set(psutil.pids()) - {os.getpid()}:
        with contextlib.suppress(OSError), open('/proc/{}/environ'.format(pid), 'rb') as file:
            if marker.encode() in file.read().split(b'\0'):     # psutil reads much more
                found.append(pid)
    processes = []
    for pid in found:
        with contextlib.suppress(psutil.NoSuchProcess):
            processes.append(psutil.Process(pid))
    return command_lines(processes)


def end_all(marker: str) -> None:
    """Kill all processes with this marker, and what they have started meanwhile."""
    def are_gone():
        found = marked(marker)
        for pid in found:
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        return not found
    wait_for(are_gone, lambda: 'the end of {}'.format(marked(marker)))


class Ports(NamedTuple):
    """(protocol, port) of sockets: of all, and of those that other machines can reach."""

    all: Set[Tuple[str, int]]
    open_to_others: Set[Tuple[str, int]]


def ports(pids, kind: str = 'inet') -> Ports:
    """Return where processes wait: the listening TCP sockets, and the unconnected UDP sockets.

    Those that are bound to the loopback are closed to others. kind: of psutil, such as 'tcp'.
    """
    result = Ports(set(), set())
    for pid in pids:
        found: List = []
        with contextlib.suppress(psutil.NoSuchProcess):
            found = psutil.Process(pid).connections(kind)
        for each in found:
            is_udp = each.type == socket.SOCK_DGRAM
            if each.status == psutil.CONN_LISTEN or is_udp and not each.raddr:
                port = 'udp' if is_udp else 'tcp', each.laddr.port
                result.all.add(port)
                if each.laddr.ip not in _LOOPBACK:
                    result.open_to_others.add(port)
    return result
