"""Choose the master of a demo, so that no demo takes the names of another one's nodes.

The master forgets the first of two nodes with one name, and that node ends: a second demo on the
same master would end the first one.
"""
import contextlib
import fcntl
import os
import socket
import subprocess
import sys
import time
import urllib.parse

from img_recog.command_line.messages import message
from img_recog.errors import UserError, shortened
from img_recog.ros import timed_xmlrpc

_FILE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'build',
                     'master')
_FIRST_PORT, _LAST_PORT = 11311, 11811
_STARTS_NOTHING = {'--ros-args', '--nodes', '--files', '--find-node', '--dump-params', '--args'}
_PORT_OPTIONS = ('-p', '--port')
# of these, two on one master make no sense; a second page or window does no harm
_PARTS = {'gazebo', 'robots', 'usb_cam', 'color_extract', 'turtlebot3_teleop_keyboard'}
_NAME = '/img_recog_demo'
_CALL_TIMEOUT_S, _FIRST_NODE_TIMEOUT_S, _POLL_PERIOD_S = 2.0, 10.0, 0.2


class Claim:
    """The master of this demo, which other demos on this machine leave alone until this ends."""

    def __init__(self, words):
        """Set ROS_MASTER_URI, unless the user has; write it to a file for ./run shell.

        words: for roslaunch. Raises UserError if another demo uses the master of the user.
        """
        self._words, self._mark, self._file = words, None, None
        if _STARTS_NOTHING.intersection(words):
            return
        port = next((words[i + 1] for i, word in enumerate(words) if word in _PORT_OPTIONS), '')
        uri = 'http://localhost:' + port if port else os.environ.get('ROS_MASTER_URI', '')
        if uri:
            _check_address(uri)
            self._check(uri)
        else:
            uri = os.environ['ROS_MASTER_URI'] = self._free()
        self._write(uri)

    def close(self):
        """Remove the file."""
        if self._file is not None:
            os.remove(self._file.name)

    def _check(self, uri):
        if not self._mark_used(uri):
            # that demo may be starting
            end = time.monotonic() + _FIRST_NODE_TIMEOUT_S
            while not (_nodes(uri) or set()) - {'/rosout'} and time.monotonic() < end:
                time.sleep(_POLL_PERIOD_S)
        taken = self._taken(uri)
        if taken:
            raise UserError(
                message('the master {} has {} of another demo, which this one would end', uri,
                        taken),
                message('stop that one, or set ROS_MASTER_URI to another port, like '
                        'http://localhost:{}', _FIRST_PORT + 1))

    def _free(self):
        """Return the first master that no demo uses; say so if it is not the usual one."""
        user = message('another demo')
        for port in range(_FIRST_PORT, _LAST_PORT + 1):
            uri = 'http://localhost:{}'.format(port)
            if not self._mark_used(uri):
                continue
            if not _is_listening(port):
                break
            if port == _FIRST_PORT:
                taken = self._taken(uri)
                if not taken and _nodes(uri) is not None:       # a separate roscore
                    break
                user = (message('another demo ({})', taken) if taken else
                        message('another program'))
            self._mark.close()
        else:
            raise UserError(message('no free port from {} to {}', _FIRST_PORT, _LAST_PORT),
                            message('set ROS_MASTER_URI'))
        if port != _FIRST_PORT:
            sys.stdout.write('[run] {}\n'.format(message(
                '{} uses port {}; ./run shell in this folder finds the master of this demo, in '
                'other terminals run "export ROS_MASTER_URI={}"', user, _FIRST_PORT, uri)))
            sys.stdout.flush()
        return uri

    def _mark_used(self, uri):
        """Mark a master as used until this process ends; return whether no other demo has."""
        address = urllib.parse.urlsplit(uri).netloc.replace('127.0.0.1', 'localhost')
        self._mark = socket.socket(socket.AF_UNIX)
        try:
            # in no folder: for all users of this machine, and gone with this process
            self._mark.bind('\0img_recog demo ' + address[:80])
        except OSError:
            self._mark.close()
            return False
        return True

    def _taken(self, uri):
        """Return the names on a master that this demo would take from nodes that answer."""
        running = {node for node in _nodes(uri) or () if node.rpartition('/')[2] in _PARTS}
        if not running:
            return ''
        listed = subprocess.run(
            ['roslaunch', '--nodes', 'img_recog', 'demo.launch', *self._words],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False,
            universal_newlines=True)
        with contextlib.suppress(OSError), _called(uri) as master:
            answers = master.ask_nodes(running.intersection(listed.stdout.split()),
                                       lambda _, node: node.getPid(_NAME))
            return ', '.join(name for name, (_, answer) in answers.items()
                             if not isinstance(answer, Exception))
        return ''

    def _write(self, uri):
        self._file = open('{}.{}'.format(_FILE, os.getpid()), 'w')
        # unlocked when this process ends, however it does
        fcntl.flock(self._file, fcntl.LOCK_EX)
        self._file.write(uri + '\n')
        self._file.flush()


def _check_address(uri):
    """Raise UserError for an address at which no master is, and roslaunch starts none."""
    try:
        address = urllib.parse.urlsplit(uri)
        is_complete = address.scheme in ('http', 'https') and address.hostname and address.port
    except ValueError:          # e.g. a port that is not a number
        is_complete = False
    if not is_complete:
        raise UserError(
            message('ROS_MASTER_URI: got {}, allowed is http://HOST:PORT', shortened(uri)),
            message('set it to http://localhost:{}, or run "unset ROS_MASTER_URI"', _FIRST_PORT))
    if _nodes(uri) is not None:
        return
    try:
        found = socket.getaddrinfo(address.hostname, 0, type=socket.SOCK_STREAM)
        with socket.socket(found[0][0]) as own:
            own.bind(found[0][4])       # an address of this computer: roslaunch starts the master
    except OSError:
        raise UserError(
            message('ROS_MASTER_URI: no master answers at {}, which is not this computer',
                    shortened(uri)),
            message('start roscore there, or run "unset ROS_MASTER_URI"'))


def _is_listening(port):
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            other.bind(('', port))
        except OSError:
            return True
    return False


def _nodes(uri):
    """Return the nodes of a master, None if no master answers."""
    with contextlib.suppress(OSError), _called(uri) as master:
        return master.state().nodes
    return None


def _called(uri):
    return timed_xmlrpc.Master(uri, _NAME, _CALL_TIMEOUT_S)
