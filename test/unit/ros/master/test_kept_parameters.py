"""The parameters of a node are kept, and set on a new master."""
import http.client
import itertools
import signal
import socket
import subprocess
import threading
import time
import xmlrpc.client

import pytest

from img_recog.ros.master.kept_parameters import KeptParameters
from img_recog_testing.waiting import DEADLINE_S, wait_for

RUN_IDS = itertools.count()
PRIVATE = {'number': 5, 'real': 0.1, 'flag': True, 'text': '\u00e4 <&>', 'list': [1, 'a', [2.5]],
           'group': {'x': {'y': 1}}}
SIGNALS = (signal.SIGINT,)


class RunningMaster:
    """A master, in a process of its own."""

    def __init__(self, port, values=None, run_id=True):
        self.port, self.uri = port, 'http://127.0.0.1:{}'.format(port)
        self._process = subprocess.Popen(
            ['rosmaster', '--core', '-p', str(port)], stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        self.proxy = xmlrpc.client.ServerProxy(self.uri)
        wait_for(self._answers, 'the master')
        for name, value in (values or {}).items():
            self.proxy.setParam('/test', name, value)
        if run_id:
            self.proxy.setParam('/test', '/run_id', str(next(RUN_IDS)))

    def _answers(self):
        try:
            return self.proxy.getPid('/test')
        except OSError:
            return False

    def get(self, name):
        code, _, value = self.proxy.getParam('/test', name)
        return value if code == 1 else None

    def set_raw(self, name, value):
        """Set a value that xmlrpc.client does not write."""
        connection = http.client.HTTPConnection('127.0.0.1', self.port)
        body = xmlrpc.client.dumps(('/test', name, 'RAW'), 'setParam').replace(
            '<string>RAW</string>', value)
        connection.request('POST', '/', body, {'Content-Type': 'text/xml'})
        assert b'Fault' not in connection.getresponse().read()
        connection.close()

    def stop(self):
        """Kill it, if it runs."""
        self.proxy('close')()
        self._process.kill()
        self._process.wait()


@pytest.fixture
def start_master(monkeypatch, tmp_path):
    """A function that starts a master on the port of this test."""
    monkeypatch.setenv('ROS_HOSTNAME', 'localhost')
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    masters = []
    with socket.socket() as reserved:       # bound, so that no other program gets the port
        reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        reserved.bind(('127.0.0.1', 0))

        def start(values=None, **more):
            masters.append(RunningMaster(reserved.getsockname()[1], values, **more))
            return masters[-1]
        yield start
        for each in masters:
            each.stop()


@pytest.fixture
def kept(monkeypatch):
    """A function that keeps the parameters of /ns/node as a master has them; and the lines."""
    def keep(uri, is_complete=True, timeout_s=DEADLINE_S):
        monkeypatch.setenv('ROS_MASTER_URI', uri)
        monkeypatch.setenv('ROS_NAMESPACE', '/ns')
        lines = []
        kept = KeptParameters(['program', '__name:=node'], lines.append, SIGNALS, timeout_s, 0.05)
        kept.keep()
        if is_complete:
            wait_for(lambda: kept.are_known, 'the parameters')
        return kept, lines
    return keep


def never():
    return False


def values():
    """Return the parameters of a launch file."""
    return dict({'/ns/node/' + name: value for name, value in PRIVATE.items()},
                **{'/use_sim_time': True, '/robot_description': '<robot/>', '/other': 1,
                   '/ns/node2/x': 1})


def test_a_new_master_gets_what_it_does_not_have(start_master, kept):
    old = start_master(values())
    kept, lines = kept(old.uri)
    old.stop()
    new = start_master({'/ns/node/number': 6, '/use_sim_time': False})
    kept.set_again(never)
    assert new.get('/ns/node') == dict(PRIVATE, number=6)
    assert [new.get(name) for name in ('/use_sim_time', '/robot_description', '/other')] == [
        False, '<robot/>', None]
    assert lines == ['has set 6 parameters on a new master']


def test_what_was_deleted_on_the_same_master_stays_deleted(start_master, kept):
    master = start_master(values())
    kept, lines = kept(master.uri)
    master.proxy.deleteParam('/test', '/ns/node/flag')
    kept.set_again(never)
    assert master.get('/ns/node/flag') is None and lines == []


def test_a_new_master_without_a_run_id_gets_them_too(start_master, kept):
    old = start_master(values(), run_id=False)
    kept, _ = kept(old.uri)
    old.stop()
    new = start_master(run_id=False)
    kept.set_again(never)
    assert new.get('/ns/node') == PRIVATE


def test_what_xmlrpc_cannot_transmit_is_skipped(start_master, kept):
    old = start_master(values())
    old.set_raw('/ns/node/wide', '<i8>5000000000</i8>')
    old.set_raw('/robot_description', '<i8>5000000000</i8>')
    kept, _ = kept(old.uri)
    old.stop()
    new = start_master()
    kept.set_again(never)
    assert new.get('/ns/node') == PRIVATE and new.get('/robot_description') is None


def test_it_waits_for_a_master_and_says_so_once(start_master, kept):
    old = start_master(values())
    kept, lines = kept(old.uri)
    old.stop()
    asked = itertools.count()
    kept.set_again(lambda: next(asked) > 6)
    assert lines == ['waits for the master at {} to answer: Connection refused'.format(old.uri)]
    waiting = threading.Thread(target=kept.set_again, args=(never,))
    waiting.start()
    new = start_master()
    waiting.join(DEADLINE_S)
    assert new.get('/ns/node') == PRIVATE


def test_a_suspended_master_does_not_delay_an_end(kept, start_master):
    old = start_master(values())
    kept, _ = kept(old.uri, timeout_s=2 * DEADLINE_S)
    old.stop()
    with socket.socket() as suspended:
        suspended.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        suspended.bind(('127.0.0.1', old.port))
        suspended.listen(8)
        begin_s = time.monotonic()
        kept.set_again(lambda: time.monotonic() > begin_s + 0.2)
        assert time.monotonic() - begin_s < DEADLINE_S


@pytest.mark.parametrize('uri', ['', 'x', 'http://', 'http://[', 'http://127.0.0.1:99999'])
def test_a_wrong_address_is_ignored(kept, uri):
    kept, lines = kept(uri, is_complete=False)
    kept.set_again(never)
    assert lines == []


def test_a_program_without_a_name_is_no_node(monkeypatch, start_master):
    monkeypatch.setenv('ROS_MASTER_URI', start_master().uri)
    kept = KeptParameters(['program'], print, SIGNALS)
    kept.keep()
    kept.set_again(never)
    assert not kept.node and not kept.are_known


def test_no_address_of_a_master():
    with pytest.raises(ValueError, match='__master'):
        KeptParameters(['program', '__name:=a', '__master:='], print, SIGNALS)


@pytest.mark.parametrize('namespace, words, name', [
    ('', ['__name:=a'], '/a'), ('/', ['__name:=a'], '/a'), ('b/c', ['__name:=a'], '/b/c/a'),
    ('/b/', ['__name:=a', '__ns:=/d'], '/d/a')])
def test_the_name_of_the_node(monkeypatch, namespace, words, name):
    monkeypatch.setenv('ROS_NAMESPACE', namespace)
    assert KeptParameters(words, print, SIGNALS).node == name
