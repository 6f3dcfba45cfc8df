"""Queues between the callbacks of a node and its loop."""
import threading
from concurrent.futures import Future
from typing import Any, Callable, List, Optional, Tuple


class _Wakeable:
    """What a loop waits for; the wait can be ended."""

    def __init__(self):
        self._condition = threading.Condition()
        self._is_woken = False

    def wake(self) -> None:
        """End the wait of the loop now; if it does not wait, its next wait ends immediately."""
        with self._condition:
            self._is_woken = True
            self._condition.notify()


class LatestValue(_Wakeable):
    """Holds the newest item only. Callbacks put, one loop takes.

    The loop does not wait in a queue.SimpleQueue: in CPython 3.11, `get` with a timeout waits
    forever after a signal handler that takes longer than the rest of the timeout. Do not call the
    methods in a signal handler, which may interrupt one of them.
    """

    def __init__(self) -> None:
        super().__init__()
        self._item: Optional[Any] = None

    def put(self, item: Any) -> Optional[Any]:
        """Store the item; return the previous one if it was never taken."""
        with self._condition:
            replaced, self._item = self._item, item
            self._condition.notify()
        return replaced

    def take(self, timeout_s: float = 0.0) -> Optional[Any]:
        """Remove and return the item, waiting up to `timeout_s` for it; None if there is none."""
        if timeout_s <= 0 and self._item is None:       # without the lock, which takes longer
            return None
        with self._condition:
            self._condition.wait_for(lambda: self._item is not None or self._is_woken, timeout_s)
            item, self._item, self._is_woken = self._item, None, False
        return item


class CallQueue(_Wakeable):
    """Calls from service handlers, executed in the thread of the loop."""

    def __init__(self) -> None:
        super().__init__()
        self._waiting: List[Tuple[Callable[[], Any], Future]] = []

    def __len__(self) -> int:
        return len(self._waiting)

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
        if not self._waiting and timeout_s <= 0:
            return
        with self._condition:
            if not (self._waiting or self._is_woken):
                self._condition.wait(timeout_s)
            waiting, self._waiting, self._is_woken = self._waiting, [], False
        for action, future in waiting:
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(action())
                except Exception as error:      # is raised in the caller, not in the loop
                    future.set_exception(error)
