"""LatestValue and CallQueue between threads."""
import concurrent.futures
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from img_recog.ros import queues
from img_recog.ros.queues import CallQueue, LatestValue
from img_recog_helpers.waiting import DEADLINE_S, wait_for


class Asker(threading.Thread):
    """Makes a call in a separate thread, like a service handler, and keeps its result or error."""

    def __init__(self, requests, action, timeout_s=DEADLINE_S):
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
        self.join(DEADLINE_S)
        assert not self.is_alive()
        return self


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


@pytest.mark.parametrize('end, result', [(lambda slot: slot.put('frame'), 'frame'),
                                         (lambda slot: slot.wake(), None)], ids=['put', 'wake'])
def test_the_wait_ends_when_there_is_a_value_and_when_it_is_woken(end, result):
    slot = LatestValue()
    with ThreadPoolExecutor(1) as pool:
        taken = pool.submit(slot.take, 3 * DEADLINE_S)
        time.sleep(0.05)        # it most likely waits then; it ends in any case
        end(slot)
        assert taken.result(DEADLINE_S) == result
    slot.put('next')
    assert slot.take(DEADLINE_S) == 'next'
    begin_s = time.monotonic()
    assert slot.take(0.05) is None and time.monotonic() - begin_s >= 0.05   # no wake is left over


def test_it_can_be_woken_before_it_waits():
    slot = LatestValue()
    slot.wake()
    slot.wake()
    begin_s = time.monotonic()
    assert slot.take(DEADLINE_S) is None
    assert time.monotonic() - begin_s < DEADLINE_S / 2


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
    watchdog = threading.Timer(DEADLINE_S, slot.put, ('endless',))
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

    class Begun(concurrent.futures.Future):
        def result(self, timeout=None):
            begun.wait(DEADLINE_S)
            return super().result(timeout)
    monkeypatch.setattr(queues, 'Future', Begun)

    def slow():
        begun.set()
        after.append(go_on.wait(DEADLINE_S))
    loop = threading.Thread(target=lambda: requests.process(DEADLINE_S), daemon=True)
    loop.start()
    asker = Asker(requests, slow, timeout_s=0.01).end()
    assert isinstance(asker.error, concurrent.futures.TimeoutError)
    go_on.set()
    loop.join(DEADLINE_S)
    assert after == [True] and not loop.is_alive()


def test_calls_run_in_the_order_they_were_made():
    requests, order, askers = CallQueue(), [], []
    for number in range(5):
        askers.append(Asker(requests, lambda number=number: order.append(number)))
        wait_for(lambda: len(requests) == len(askers), 'the call')
    requests.process(0.0)
    assert [asker.end().error for asker in askers] == [None] * 5
    assert order == [0, 1, 2, 3, 4]
