"""What is new since a page got the last news. Independent of ROS."""
import threading
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

_MAX_EVENTS = 900       # about 10 s of a demo
_MAX_PATH = 4000        # points
_PATH_STEP_M = 0.02


class News:
    """Events, of which each is sent once, and states, of which only the last counts.

    A cursor is the number of the last change that somebody got. All methods may be called by any
    thread. Values are what JSON knows, without NaN.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._number = 0
        self._events: Deque[Tuple[int, str, Any]] = deque(maxlen=_MAX_EVENTS)
        self._states: Dict[str, Tuple[int, Any]] = {}
        self._path: Deque[Tuple[float, float]] = deque(maxlen=_MAX_PATH)

    def add(self, kind: str, value: Any) -> None:
        """Add an event."""
        with self._lock:
            self._number += 1
            self._events.append((self._number, kind, value))

    def set(self, kind: str, value: Any) -> None:
        """Set a state."""
        with self._lock:
            self._number += 1
            self._states[kind] = self._number, value

    def extend_path(self, x: float, y: float) -> None:
        """Add a position to the path, in m, if it is far enough from the last one."""
        with self._lock:
            if self._path:
                last_x, last_y = self._path[-1]
                if abs(x - last_x) + abs(y - last_y) < _PATH_STEP_M:
                    return
            self._path.append((x, y))

    def clear(self) -> None:
        """Forget everything: what was measured before is not the beginning of what follows."""
        with self._lock:
            self._events.clear()
            self._states.clear()
            self._path.clear()

    def since(self, cursor: Optional[int]) -> Tuple[int, Dict[str, Any]]:
        """Return the cursor of the last change, and what came after `cursor`; None for all.

        Events as lists by their kind, states by their kind, and for None the path.
        """
        is_first, cursor = cursor is None, cursor or 0
        with self._lock:
            news: Dict[str, Any] = {kind: value for kind, (number, value) in self._states.items()
                                    if number > cursor}
            events: Dict[str, List[Any]] = {}
            for number, kind, value in reversed(self._events):
                if number <= cursor:
                    break
                events.setdefault(kind, []).append(value)
            news.update({kind: values[::-1] for kind, values in events.items()})
            if is_first and self._path:
                news['path'] = list(self._path)
            return self._number, news
