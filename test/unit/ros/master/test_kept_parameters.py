"""The parameters of a node are kept, and set on a new master."""
import itertools
import signal
import threading
import time

import pytest

from img_recog.ros.master.kept_parameters import KeptParameters
from img_recog_testing.waiting import DEADLINE_S, wait_for

PRIVATE = {'number': 5, 'real': 0.1, 'flag': True, 'text': '\u00e4 <&>', 'list': [1, 'a', [2.5]],
           'group': {'x': {'y': 1}}}
SHARED = {'/use_sim_time': True, '/robot_description': '<robot/>'}
SIGNALS = (signal.SIGINT,)


@pytest.fixture
def keep(monkeypatch):
    """A function that keeps the parameters of /ns/node on a master; and returns the lines too."""
    def keep(is_complete=True, timeout_s=DEADLINE_S):
        monkeypatch.setenv('ROS_NAMESPACE', '/ns')
        lines = []
        kept = KeptParameters(['program', '__name:=node'], lines.append, SIGNALS, timeout_s, 0.05)
        kept.keep()
        if is_complete:
            wait_for(lambda: kept.are_known, 'the parameters')
        return kept, lines
    return keep


@pytest.fixture
def launched(master):
    """A master with the parameters of a launch file."""
    master.renew({**full(PRIVATE), **SHARED, '/other': 1, '/ns/node2/x': 1, '/run_id': 'old'})
    return master


def full(private):
    return {'/ns/node/' + name: value for name, value in private.items()}


def never():
    return False


def test_a_new_master_gets_what_it_does_not_have(launched, keep):
    kept, lines = keep()
    own = {'/ns/node/number': 6, '/use_sim_time': False, '/run_id': 'new'}
    launched.renew(own)
    kept.set_again(never)
    assert launched.parameters == {**full(PRIVATE), **SHARED, **own}
    assert lines == ['has set 6 parameters on a new master']


@pytest.mark.parametrize('run_id', ['old', None])
def test_a_master_is_new_by_its_process_or_if_it_has_no_run_id(launched, keep, run_id):
    launched.parameters['/run_id'] = run_id
    kept, _ = keep()
    launched.renew({'/run_id': run_id})
    kept.set_again(never)
    assert launched.parameters == {**full(PRIVATE), **SHARED, '/run_id': run_id}


def test_what_was_deleted_on_the_same_master_stays_deleted(launched, keep):
    kept, lines = keep()
    del launched.parameters['/ns/node/flag']
    kept.set_again(never)
    assert '/ns/node/flag' not in launched.parameters and lines == []


def test_what_xmlrpc_cannot_transmit_is_skipped(launched, keep):
    launched.parameters.update({'/ns/node/wide': 1 << 40, '/robot_description': 1 << 40})
    kept, _ = keep()
    launched.renew()
    kept.set_again(never)
    assert launched.parameters == {**full(PRIVATE), '/use_sim_time': True}


def test_it_waits_for_a_master_and_says_so_once(launched, keep):
    kept, lines = keep()
    launched.stop()
    asked = itertools.count()
    kept.set_again(lambda: next(asked) > 6)
    assert lines == [
        'waits for the master at {} to answer: Connection refused'.format(launched.uri)]
    waiting = threading.Thread(target=kept.set_again, args=(never,))
    waiting.start()
    launched.renew()
    launched.start()
    waiting.join(DEADLINE_S)
    assert launched.parameters == {**full(PRIVATE), **SHARED}


def test_a_suspended_master_does_not_delay_an_end(launched, keep):
    kept, _ = keep(timeout_s=2 * DEADLINE_S)
    launched.free.clear()
    begin_s = time.monotonic()
    kept.set_again(lambda: time.monotonic() > begin_s + 0.2)
    assert time.monotonic() - begin_s < DEADLINE_S


@pytest.mark.parametrize('uri', ['', 'x', 'http://', 'http://[', 'http://127.0.0.1:99999'])
def test_a_wrong_address_is_ignored(keep, monkeypatch, uri):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    kept, lines = keep(is_complete=False)
    kept.set_again(never)
    assert lines == []


def test_a_program_without_a_name_is_no_node(launched):
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
