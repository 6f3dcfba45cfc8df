"""Hooks are called once, also if they are added during or after a shutdown."""
import subprocess
import sys
import threading
from unittest.mock import MagicMock

import pytest
import rospy
from std_msgs.msg import String

from img_recog.errors import UserError
from img_recog.ros import lifecycle
from img_recog.settings import ParameterError
from img_recog_helpers.waiting import DEADLINE_S


@pytest.fixture
def shutdown(monkeypatch):
    """A function that shuts down rospy in a thread; rospy's state is restored after the test.

    Its argument is a pre-shutdown hook for rospy.
    """
    for name in ('_client_shutdown_hooks', '_preshutdown_hooks', '_shutdown_hooks',
                 '_shutdown_threads'):
        monkeypatch.setattr(rospy.core, name, [])
    for name in ('_shutdown_flag', '_in_shutdown'):
        monkeypatch.setattr(rospy.core, name, False)
    threads = []

    def begin(hook=None):
        if hook is not None:
            rospy.core.add_preshutdown_hook(lambda _: hook())
        threads.append(threading.Thread(target=rospy.signal_shutdown, args=('test',)))
        threads[-1].start()
        return threads[-1]
    yield begin
    for thread in threads:
        thread.join()


@pytest.mark.parametrize('is_late', [False, True])
def test_hook_before_or_after_the_shutdown_is_called_once(shutdown, is_late):
    calls = []
    if is_late:
        shutdown().join()
    lifecycle.on_shutdown(lambda: calls.append(1))
    assert calls == [1] * is_late
    shutdown().join()
    assert calls == [1]


class _Door:
    """A lock that calls `on_knock` when a thread has to wait for it."""

    def __init__(self, on_knock):
        self._lock, self._on_knock = threading.Lock(), on_knock

    def __enter__(self):
        if not self._lock.acquire(blocking=False):
            self._on_knock()
            self._lock.acquire()

    def __exit__(self, *_):
        self._lock.release()


def test_hook_while_rospy_closes_its_topics_is_called_once(shutdown, monkeypatch):
    calls, closing, knocked = [], threading.Event(), threading.Event()
    monkeypatch.setattr(rospy.core, '_shutdown_lock', _Door(knocked.set))

    def close():
        closing.set()
        assert knocked.wait(DEADLINE_S)
    thread = shutdown(close)
    assert closing.wait(DEADLINE_S)
    lifecycle.on_shutdown(lambda: calls.append(1))
    thread.join()
    assert knocked.is_set()
    assert calls == [1]


@pytest.fixture
def exit_code(shutdown, monkeypatch):
    """A function that runs a node without a master; it returns the exit code."""
    for module in ('log_handlers', 'master_watch', 'rosout', 'signals'):
        monkeypatch.setattr(lifecycle, module, MagicMock())
    monkeypatch.setattr(lifecycle, 'END_LIMIT_S', 1e6)      # it would end the tests
    return lambda serve: lifecycle.run('node', serve)


def _raise(error):
    raise error


@pytest.mark.parametrize('is_supervised', [False, True])
@pytest.mark.parametrize('serve, alone, supervised', [
    (lambda: None, 0, 0),
    (lambda: _raise(UserError('no file')), 1, 1),
    (lambda: _raise(ParameterError('not allowed')), 1, 78),
    (lambda: _raise(KeyError('a mistake')), 70, 70),
    (lambda: _raise(rospy.ROSException('a mistake')), 70, 70),
    (lambda: _raise(ConnectionRefusedError()), 1, 75),
    (lambda: rospy.signal_shutdown('signal 2'), 0, 77),
    (lambda: rospy.signal_shutdown('external shutdown request from [/rosnode]: [user request]'),
     0, 77),
    (lambda: rospy.signal_shutdown('external shutdown request from [/master]: [[/node] Reason: '
                                   'new node registered with same name]'), 0, 76)])
def test_exit_code_tells_a_supervisor_whether_to_start_again(
        exit_code, monkeypatch, is_supervised, serve, alone, supervised):
    if is_supervised:
        monkeypatch.setenv('IMG_RECOG_RESPAWN', '1')
    else:
        monkeypatch.delenv('IMG_RECOG_RESPAWN', raising=False)
    assert exit_code(serve) == (supervised if is_supervised else alone)


def _use_a_closed_topic(_=None):
    rospy.Publisher('/closed', String, queue_size=1).impl.remove_connection(None)


@pytest.mark.parametrize('is_requested, serve, code', [
    (True, lambda: _raise(rospy.ROSException('publish() to a closed topic')), 0),
    (True, _use_a_closed_topic, 0),
    (True, lambda: _raise(TypeError('a mistake')), 70),
    (False, _use_a_closed_topic, 70)])
def test_errors_in_rospy_during_a_shutdown_are_no_mistake(exit_code, monkeypatch, is_requested,
                                                          serve, code):
    monkeypatch.delenv('IMG_RECOG_RESPAWN', raising=False)
    monkeypatch.setattr(rospy.topics, 'is_initialized', lambda: True)
    monkeypatch.setattr(rospy.core, 'is_shutdown_requested', lambda: is_requested)
    assert exit_code(serve) == code


# without a master, and with a lock in which the main thread waits without running Python code
_NODE = '''
import ctypes, os, signal, sys, threading, time
import rospy
from img_recog.ros import lifecycle
lifecycle.rosout.init_node = lambda *_, **__: None
lifecycle.master_watch.start = lambda _: None
mutex, library = ctypes.create_string_buffer(64), ctypes.CDLL(None)
def interrupt_soon():
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
'''
# a node on whose end the master does not answer rospy, and maybe not its own thread either
_BLOCKED = _NODE + '''
lifecycle.END_LIMIT_S = 0.1
rospy.core.add_shutdown_hook(lambda _: threading.Event().wait())
def serve():
    if sys.argv[1] == 'sleeps':      # in a library, before the signal comes and for ever
        interrupt_soon()
        while True:
            library.pthread_mutex_lock(mutex)
    if sys.argv[1] != 'fails':
        os.kill(os.getpid(), signal.SIGINT)
    if sys.argv[1] == 'waits':
        threading.Event().wait()
    if sys.argv[1] == 'fails':
        raise KeyError('a mistake')
    sys.stdout.write('served')
sys.exit(lifecycle.run('node', serve))
'''


@pytest.mark.parametrize('how, output, is_supervised, code', [
    ('returns', 'served', False, 0), ('returns', 'served', True, 77), ('waits', '', False, 0),
    ('waits', '', True, 77), ('fails', '', False, 70), ('sleeps', '', False, 0)])
def test_a_node_ends_while_the_master_does_not_answer(monkeypatch, how, output, is_supervised,
                                                      code):
    if is_supervised:
        monkeypatch.setenv('IMG_RECOG_RESPAWN', '1')
    else:
        monkeypatch.delenv('IMG_RECOG_RESPAWN', raising=False)
    done = subprocess.run([sys.executable, '-c', _BLOCKED, how], stdout=subprocess.PIPE,
                          universal_newlines=True, timeout=DEADLINE_S)
    assert (done.returncode, done.stdout) == (code, output)


# a node whose main thread waits in a library, until its own hook wakes it
_WOKEN = _NODE + '''
def unregister(_):
    time.sleep(0.5)
    sys.stdout.write('unregistered')
rospy.core.add_shutdown_hook(unregister)
def serve():
    lifecycle.on_shutdown(lambda: library.pthread_mutex_unlock(mutex))
    library.pthread_mutex_lock(mutex)
    interrupt_soon()
    library.pthread_mutex_lock(mutex)
sys.exit(lifecycle.run('node', serve))
'''


def test_a_node_is_unregistered_before_it_ends_at_a_signal(monkeypatch):
    monkeypatch.delenv('IMG_RECOG_RESPAWN', raising=False)
    done = subprocess.run([sys.executable, '-c', _WOKEN], stdout=subprocess.PIPE,
                          universal_newlines=True, timeout=DEADLINE_S)
    assert (done.returncode, done.stdout) == (0, 'unregistered')
