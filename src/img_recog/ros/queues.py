"""Queues between the callbacks of a node and its loop."""
import queue
import threading
from concurrent.futures import Future
from typing import Any, Callable, Optional


class LatestValue:
    """Holds the newest item only. A callback puts, the loop takes."""

    def __init__(self):
        self._items = queue.SimpleQueue()

    def put(self, item: Any) -> Optional[Any]:
        """Store the item; return the previous one if it was never taken."""
        replaced = self.take()
        self._items.put(item)
        return replaced

    def take(self, timeout_s: float = 0.0) -> Optional[Any]:
        """Remove and return the item, waiting up to `timeout_s` for it; None if there is none."""
        item = self._next(timeout_s)
        while not self._items.empty():      # two callbacks put at the same time
            newer = self._next()
            item = item if newer is None else newer
        return item

    def _next(self, timeout_s: float = 0.0) -> Optional[Any]:
        try:
            return self._items.get(timeout_s > 0, timeout_s)
        except queue.Empty:
            return None


class CallQueue:
    """Calls from service handlers, executed in the thread of the loop."""

    def __init__(self):
        self._condition = threading.Condition()
        self._waiting = []

    def call(self, action: Callable[[], Any], timeout_s: float) -> Any:
        """Have the loop call `action`; return what it returns, raise what it raises.

        Raises concurrent.futures.TimeoutError when the call does not end in time; a call that
        has not begun by then is cancelled.
        """
        future: Future = Future()
        with self._condition:
            self._waiting.append((action, future))
            self._condition.notify()
        try:
            return future.result(timeout_s)
        finally:
            future.cancel()

    def process(self, timeout_s: float) -> None:
        """Execute the waiting calls, or wait up to `timeout_s` for the first; for the loop."""
        with self._condition:
            if not self._waiting and timeout_s > 0:
                self._condition.wait(timeout_s)
            waiting, self._waiting = self._waiting, []
        for action, future in waiting:
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(action())
                except Exception as error:      # is raised in the caller, not in the loop
                    future.set_exception(error)
