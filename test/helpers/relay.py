"""Passes Ethernet frames between two namespaces, later, and loses some.

usage: relay.py DEVICE NAMESPACE OTHER_DEVICE DELAY_S LOSS; DEVICE is made in this namespace.
"""
import collections
import ctypes
import fcntl
import os
import random
import select
import struct
import sys
import time

_TUNSETIFF, _IFF_TAP, _IFF_NO_PI = 0x400454ca, 2, 0x1000
_CLONE_NEWNET = 0x40000000
_MAX_FRAME = 1 << 16
_MAX_WAITING = 1000         # frames, like the queue of netem


def tap(name):
    """Return the descriptor of a new device in this namespace."""
    descriptor = os.open('/dev/net/tun', os.O_RDWR)
    fcntl.ioctl(descriptor, _TUNSETIFF, struct.pack('16sH22x', name.encode(),
                                                    _IFF_TAP | _IFF_NO_PI))
    return descriptor


def enter(namespace):
    """Continue in another network namespace."""
    descriptor = os.open('/run/netns/' + namespace, os.O_RDONLY)
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.setns(descriptor, _CLONE_NEWNET):
        raise OSError(ctypes.get_errno(), 'setns')
    os.close(descriptor)


def main():
    """Pass frames on until the program is ended."""
    device, namespace, other_device, delay_s, loss = sys.argv[1:]
    first = tap(device)
    enter(namespace)
    second = tap(other_device)
    others = {first: second, second: first}
    randomness = random.Random(1)
    waiting = collections.deque()
    while True:
        timeout_s = None if not waiting else max(0.0, waiting[0][0] - time.monotonic())
        readable, _, _ = select.select([first, second], [], [], timeout_s)
        for descriptor in readable:
            frame = os.read(descriptor, _MAX_FRAME)
            if len(waiting) < _MAX_WAITING and randomness.random() >= float(loss):
                waiting.append((time.monotonic() + float(delay_s), others[descriptor], frame))
        while waiting and waiting[0][0] <= time.monotonic():
            _, descriptor, frame = waiting.popleft()
            try:
                os.write(descriptor, frame)
            except OSError:         # the device is down
                pass


if __name__ == '__main__':
    main()
