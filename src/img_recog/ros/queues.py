"""Where callbacks leave what they received for the one loop of a node."""
import queue
import threading
from concurrent.futures import Future
from typing import Any, Callable, Optional


class LatestValue:
    """Holds the newest item only: a callback puts, the loop takes."""

    def __init__(self):
        self._items = queue.SimpleQueue()

    def put(self, item: Any) -> Optional[Any]:
        """Replace what is held; return what was, which nobody has taken."""
        replaced = self.take()
        self._items.put(item)
        return replaced

    def take(self, timeout_s: float = 0.0) -> Optional[Any]:
        """Return what is held and hold nothing; wait for it up to `timeout_s`, else None."""
        item = self._next(timeout_s)
        while not self._items.empty():      # two callbacks put theirs at once
            newer = self._next()
            item = item if newer is None else newer
        return item

    def _next(self, timeout_s: float = 0.0) -> Optional[Any]:
        try:
            return self._items.get(timeout_s > 0, timeout_s)
        except queue.Empty:
            return None


class CallQueue:
    """Work that service handlers ask of the loop, done in its thread and waited for."""

    def __init__(self):
        self._condition = threading.Condition()
        self._waiting = []

    def call(self, action: Callable[[], Any], timeout_s: float) -> Any:
        """Have the loop call `action`; return what it returns, raise what it raises.

        Raises concurrent.futures.TimeoutError when the loop does not begin and end in time; what
        has not begun by then is not done later.
        """
        future = Future()
        with self._condition:
            self._waiting.append((action, future))
            self._condition.notify()
        try:
            return future.result(timeout_s)
        finally:
            future.cancel()

    def process(self, timeout_s: float) -> None:
        """Call in the loop: do what is asked, or wait up to `timeout_s` for the first request."""
        with self._condition:
            if not self._waiting and timeout_s > 0:
                self._condition.wait(timeout_s)
            waiting, self._waiting = self._waiting, []
        for action, future in waiting:
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(action())
                except Exception as error:      # belongs to whoever asked, not to the loop
                    future.set_exception(error)
