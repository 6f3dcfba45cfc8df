"""LatestValue and CallQueue between threads; synchronized by events, not by sleeps."""
import concurrent.futures
import signal
import threading
import time

import pytest

from img_recog.ros import queues
from img_recog.ros.queues import CallQueue, LatestValue

GENEROUS_S = 20.0       # reached only if a test fails


class Asker(threading.Thread):
    """Makes a call in a separate thread, like a service handler, and keeps its result or error."""

    def __init__(self, requests, action, timeout_s=GENEROUS_S):
        super().__init__(daemon=True)
        self._requests, self._action, self._timeout_s = requests, action, timeout_s
        self.result, self.error = None, None
        self.start()

    def run(self):
        try:
            self.result = self._requests.call(self._action, self._timeout_s)
        except Exception as error:
            self.error = error

    def end(self):
        self.join(GENEROUS_S)
        assert not self.is_alive()
        return self


def future_that_first_calls(action):
    """Return a Future class that calls `action` after its call was put in the queue."""
    class Announced(concurrent.futures.Future):
        def result(self, timeout=None):
            action()
            return super().result(timeout)
    return Announced


def serve_until_ended(requests, *askers):
    for _ in range(1000):
        requests.process(0.05)
        if not any(asker.is_alive() for asker in askers):
            break
    return [asker.end() for asker in askers]


def test_latest_value_is_taken_once():
    slot = LatestValue()
    assert slot.take() is None
    for item in (1, 2, 3):
        slot.put(item)
    assert slot.take() == 3
    assert slot.take() is None
    slot.put(0)
    assert slot.take() == 0


class AnnouncedLock:
    """A lock that calls `on_wait` when a thread is about to wait in it with a timeout."""

    def __init__(self, on_wait):
        self._lock, self._on_wait = threading.Lock(), on_wait
        self.locked, self.release = self._lock.locked, self._lock.release

    def acquire(self, blocking=True, timeout=-1):
        if timeout > 0 and self._lock.locked():
            self._on_wait()
        return self._lock.acquire(blocking, timeout)


def announced(slot, on_wait):
    """Return a LatestValue whose loop calls `on_wait` before it waits."""
    slot._changed = AnnouncedLock(on_wait)
    slot._changed.acquire()
    return slot


@pytest.mark.parametrize('end, result', [(lambda slot: slot.put('frame'), 'frame'),
                                         (lambda slot: slot.wake(), None)], ids=['put', 'wake'])
def test_the_wait_ends_when_there_is_a_value_and_when_it_is_woken(end, result):
    waiting, got = threading.Event(), []
    slot = announced(LatestValue(), waiting.set)
    taker = threading.Thread(target=lambda: got.append(slot.take(3 * GENEROUS_S)), daemon=True)
    taker.start()
    assert waiting.wait(GENEROUS_S)
    end(slot)
    taker.join(GENEROUS_S)
    assert got == [result]
    waiting.clear()
    slot.put('next')
    assert slot.take(GENEROUS_S) == 'next'
    assert not waiting.is_set()         # a value was there already
    assert slot.take(0.001) is None and waiting.is_set()        # and not woken by the last value


def test_it_can_be_woken_before_it_waits():
    slot = LatestValue()
    slot.wake()
    slot.wake()
    begin_s = time.monotonic()
    assert slot.take(GENEROUS_S) is None
    assert time.monotonic() - begin_s < GENEROUS_S / 2


def test_values_of_many_threads_are_replaced_or_taken_once():
    slot, numbers, replaced = LatestValue(), range(3000), []

    def put(first):
        for number in numbers[first::3]:
            replaced.append(slot.put(number))
    putters = [threading.Thread(target=put, args=(first,), daemon=True) for first in range(3)]
    for putter in putters:
        putter.start()
    taken = []
    while any(putter.is_alive() for putter in putters):
        taken.append(slot.take(0.01))
    taken.append(slot.take())
    assert sorted(item for item in taken + replaced if item is not None) == list(numbers)


def test_a_signal_handler_that_outlasts_the_timeout_does_not_make_the_wait_endless():
    """In CPython 3.11, SimpleQueue.get waits forever then."""
    slot = LatestValue()
    watchdog = threading.Timer(GENEROUS_S, slot.put, ('endless',))
    before = signal.signal(signal.SIGALRM, lambda *_: time.sleep(0.1))
    watchdog.start()
    try:
        for _ in range(3):
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            assert slot.take(0.06) is None
    finally:
        watchdog.cancel()
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_latest_value_is_none_after_the_timeout():
    assert LatestValue().take(0.01) is None


def test_the_call_runs_in_the_thread_of_the_loop():
    requests = CallQueue()
    asker, = serve_until_ended(requests, Asker(requests, lambda: (7, threading.get_ident())))
    assert asker.error is None
    assert asker.result == (7, threading.get_ident())


def test_exception_is_raised_in_the_caller_and_not_in_the_loop():
    requests = CallQueue()

    def fail():
        raise KeyError('no such model')
    first, second = serve_until_ended(requests, Asker(requests, fail),
                                      Asker(requests, lambda: 'still there'))
    assert isinstance(first.error, KeyError) and first.error.args == ('no such model',)
    assert second.result == 'still there'


def test_a_call_that_starts_late_fails_and_does_not_run_later():
    requests, done = CallQueue(), []
    with pytest.raises(concurrent.futures.TimeoutError):
        requests.call(lambda: done.append('late'), 0.01)
    requests.process(0.0)
    assert done == []
    serve_until_ended(requests, Asker(requests, lambda: done.append('in time')))
    assert done == ['in time']


def test_a_call_that_ends_late_fails_and_the_loop_continues(monkeypatch):
    requests, begun, go_on, after = CallQueue(), threading.Event(), threading.Event(), []
    monkeypatch.setattr(queues, 'Future', future_that_first_calls(
        lambda: begun.wait(GENEROUS_S)))

    def slow():
        begun.set()
        after.append(go_on.wait(GENEROUS_S))
    loop = threading.Thread(target=lambda: requests.process(GENEROUS_S), daemon=True)
    loop.start()
    asker = Asker(requests, slow, timeout_s=0.01).end()
    assert isinstance(asker.error, concurrent.futures.TimeoutError)
    go_on.set()
    loop.join(GENEROUS_S)
    assert after == [True] and not loop.is_alive()


def test_calls_run_in_the_order_they_were_made(monkeypatch):
    requests, order, arrived = CallQueue(), [], threading.Semaphore(0)
    monkeypatch.setattr(queues, 'Future', future_that_first_calls(arrived.release))
    askers = []
    for number in range(5):
        askers.append(Asker(requests, lambda number=number: order.append(number)))
        assert arrived.acquire(timeout=GENEROUS_S)
    requests.process(0.0)
    assert [asker.end().error for asker in askers] == [None] * 5
    assert order == [0, 1, 2, 3, 4]


def test_process_without_calls_returns():
    requests = CallQueue()
    requests.process(0.0)
    requests.process(0.01)
