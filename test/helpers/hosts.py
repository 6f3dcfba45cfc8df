"""Hosts of a private network on this machine, in network namespaces. Needs the rights of root."""
import os
import subprocess
import sys

from img_recog_helpers.waiting import wait_for

_SUBNET = '10.77.0.'
_SWITCH = 'switch'
_HERE = os.path.dirname(os.path.abspath(__file__))


def reason_without():
    """Return why there can be no hosts here, '' if they can be made."""
    name = 'irt{}x'.format(os.getpid())
    try:
        made = _run('ip', 'netns', 'add', name)
    except OSError as error:
        return 'ip: {}'.format(error.strerror)
    if made.returncode:
        return 'no network namespace: ' + made.stderr.strip()
    try:
        found = _run('ip', '-n', name, 'link', 'add', 'br0', 'type', 'bridge')
        return found.stderr.strip() and 'no bridge: ' + found.stderr.strip()
    finally:
        _run('ip', 'netns', 'del', name)


class Hosts:
    """Hosts that reach one another through a switch, and nothing else.

    names: of the hosts; their addresses are 10.77.0.1 and so on, in their namespaces only.
    """

    def __init__(self, *names):
        self.names = names
        self._prefix = 'irt{}'.format(os.getpid())
        self._relay = None
        self._made = []
        try:
            self._make()
        except Exception:
            self.close()
            raise

    def _make(self):
        self._add(_SWITCH)
        self._ip(_SWITCH, 'link', 'add', 'br0', 'type', 'bridge')
        self._ip(_SWITCH, 'link', 'set', 'br0', 'up')
        for number, name in enumerate(self.names):
            self._add(name)
            self._ip(name, 'link', 'add', 'eth0', 'type', 'veth', 'peer', 'name',
                     'port{}'.format(number), 'netns', self._namespace(_SWITCH))
            self._ip(_SWITCH, 'link', 'set', 'port{}'.format(number), 'master', 'br0', 'up')
            self._ip(name, 'address', 'add', self.address(name) + '/24', 'dev', 'eth0')
            self._ip(name, 'link', 'set', 'eth0', 'up')

    def _add(self, name):
        self._check(_run('ip', 'netns', 'add', self._namespace(name)))
        self._made.append(name)
        self._ip(name, 'link', 'set', 'lo', 'up')

    def _namespace(self, name):
        return '{}-{}'.format(self._prefix, name)

    def address(self, name):
        """Return the address of a host."""
        return _SUBNET + str(1 + self.names.index(name))

    def command(self, name, *words):
        """Return the command that runs a program on a host."""
        return ['ip', 'netns', 'exec', self._namespace(name), *words]

    def plug(self, name, is_in):
        """Plug the cable of a host in, or pull it out."""
        self._ip(_SWITCH, 'link', 'set', 'port{}'.format(self.names.index(name)),
                 'up' if is_in else 'down')

    def impair(self, name, delay_s, loss):
        """Delay all that a host sends and receives, and lose a share of the packets.

        By a program that passes the packets on: not every kernel has netem.
        """
        self._ip(name, 'link', 'del', 'eth0')       # its other end too
        self._relay = subprocess.Popen(
            self.command(_SWITCH, sys.executable, os.path.join(_HERE, 'relay.py'),
                         'tap0', self._namespace(name), 'eth0', str(delay_s), str(loss)))
        wait_for(lambda: not _run('ip', '-n', self._namespace(name), 'link', 'show', 'eth0')
                 .returncode, 'the relay')
        self._ip(_SWITCH, 'link', 'set', 'tap0', 'master', 'br0', 'up')
        self._ip(name, 'address', 'add', self.address(name) + '/24', 'dev', 'eth0')
        self._ip(name, 'link', 'set', 'eth0', 'up')

    def _ip(self, name, *words):
        self._check(_run('ip', '-n', self._namespace(name), *words))

    @staticmethod
    def _check(result):
        assert result.returncode == 0, '{}: {}'.format(' '.join(result.args), result.stderr)

    def close(self):
        """Remove everything; the programs must have ended."""
        if self._relay is not None:
            self._relay.terminate()
            self._relay.wait()
        for name in self._made:
            _run('ip', 'netns', 'del', self._namespace(name))


def _run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False,
                          universal_newlines=True)
