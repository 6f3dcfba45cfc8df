"""LatestValue and CallQueue between threads; synchronized by events, not by sleeps."""
import concurrent.futures
import queue
import threading

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


def test_latest_value_waits_until_there_is_one(monkeypatch):
    waiting, got = threading.Event(), []

    class Announced(queue.SimpleQueue):
        def get(self, block=True, timeout=None):
            if block and self.empty():
                waiting.set()
            return super().get(block, timeout)
    monkeypatch.setattr(queues.queue, 'SimpleQueue', Announced)
    slot = LatestValue()
    taker = threading.Thread(target=lambda: got.append(slot.take(3 * GENEROUS_S)), daemon=True)
    taker.start()
    assert waiting.wait(GENEROUS_S)
    slot.put('frame')
    taker.join(GENEROUS_S)
    assert got == ['frame']
    waiting.clear()
    slot.put('next')
    assert slot.take(GENEROUS_S) == 'next'
    assert not waiting.is_set()         # a value was there already


def test_latest_of_two_values_that_are_put_at_once(monkeypatch):
    both = threading.Barrier(2, timeout=GENEROUS_S)

    class Meeting(queue.SimpleQueue):
        def put(self, item):
            both.wait()         # both threads have seen that no value is stored
            super().put(item)
    monkeypatch.setattr(queues.queue, 'SimpleQueue', Meeting)
    slot = LatestValue()
    putters = [threading.Thread(target=slot.put, args=(item,), daemon=True) for item in 'ab']
    for putter in putters:
        putter.start()
    for putter in putters:
        putter.join(GENEROUS_S)
    assert slot.take() in 'ab'
    assert slot.take() is None


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
