"""The sockets on which processes wait for connections or packets."""
import glob
import os

_LISTENING = {'tcp': '0A', 'udp': '07'}         # state in /proc/net: TCP_LISTEN, TCP_CLOSE
_LOOPBACK = ('0100007F', '00000000000000000000000001000000')


def open_doors(pids):
    """Return (protocol, port) of each socket of the processes that another machine can reach.

    These are the listening TCP sockets, and the unconnected UDP sockets, that are not bound to
    127.0.0.1 or ::1.
    """
    waiting = {inode: (protocol, port) for protocol in _LISTENING
               for inode, address, port in _waiting(protocol) if address not in _LOOPBACK}
    return {waiting[inode] for pid in pids for inode in _inodes(pid) if inode in waiting}


def listening(pids):
    """Return the TCP ports on which the processes listen, on any address."""
    ports = {inode: port for inode, _, port in _waiting('tcp')}
    return {ports[inode] for pid in pids for inode in _inodes(pid) if inode in ports}


def _waiting(protocol):
    """Yield inode, local address and port of each waiting socket of this machine."""
    for path in ('/proc/net/' + protocol, '/proc/net/{}6'.format(protocol)):
        if os.path.exists(path):
            with open(path) as file:
                for words in map(str.split, list(file)[1:]):
                    if words[3] == _LISTENING[protocol]:
                        address, port = words[1].split(':')
                        yield words[9], address, int(port, 16)


def _inodes(pid):
    for path in glob.glob('/proc/{}/fd/*'.format(pid)):
        try:
            target = os.readlink(path)
        except OSError:         # closed meanwhile
            continue
        if target.startswith('socket:['):
            yield target[len('socket:['):-1]
