"""What is new since the last message to a page. Independent of ROS."""
import math
import threading
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

MAX_STATES = 300
_MAX_EVENTS = 900       # about 10 s of a demo
_MAX_PATH = 4000        # points
_PATH_STEP_M = 0.02
_JUMP_M = 0.5           # between two positions that follow one another: the robot was moved


class Updates:
    """Events, of which each is sent once, and states, of which only the last counts.

    A cursor is the number of the last change that somebody got. All methods may be called by any
    thread. Values are what JSON knows, without NaN.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._number = 0
        self._events: Deque[Tuple[int, str, Any]] = deque(maxlen=_MAX_EVENTS)
        self._states: Dict[str, Tuple[int, Any]] = {}
        # with their numbers; None between two positions of which the second one follows a jump
        self._path: Deque[Tuple[int, Optional[Tuple[float, float]]]] = deque(maxlen=_MAX_PATH)
        self._position: Optional[Tuple[float, float]] = None

    def add(self, kind: str, value: Any) -> None:
        """Add an event."""
        with self._lock:
            self._number += 1
            self._events.append((self._number, kind, value))

    def set(self, kind: str, value: Any) -> bool:
        """Set a state; return False if there are too many already."""
        with self._lock:
            is_known = kind in self._states or len(self._states) < MAX_STATES
            if is_known:
                self._number += 1
                self._states[kind] = self._number, value
            return is_known

    def extend_path(self, x: float, y: float) -> None:
        """Add a position to the path, in m, if it is far enough from the last one.

        To be called with each position that is measured.
        """
        with self._lock:
            last, self._position = self._position, (x, y)
            is_jump = last is not None and math.dist(last, self._position) > _JUMP_M
            end = self._path[-1][1] if self._path else None
            if not is_jump and end is not None and (
                    abs(x - end[0]) + abs(y - end[1]) < _PATH_STEP_M):
                return
            for point in (None, self._position) if is_jump else (self._position,):
                self._number += 1
                self._path.append((self._number, point))

    def clear(self) -> None:
        """Forget everything: what was measured before is no start of what follows."""
        with self._lock:
            self._events.clear()
            self._states.clear()
            self._path.clear()
            self._position = None

    def since(self, cursor: Optional[int]) -> Tuple[int, Dict[str, Any]]:
        """Return the cursor of the last change, and what came after `cursor`; None for all.

        Events as lists by their kind, states by their kind, and the path: positions, and None
        before one to which the robot was moved.
        """
        cursor = cursor or 0
        with self._lock:
            found: Dict[str, Any] = {kind: value for kind, (number, value) in self._states.items()
                                     if number > cursor}
            events: Dict[str, List[Any]] = {}
            for number, kind, value in reversed(self._events):
                if number <= cursor:
                    break
                events.setdefault(kind, []).append(value)
            found.update({kind: values[::-1] for kind, values in events.items()})
            path: Deque[Any] = deque()
            for number, point in reversed(self._path):
                if number <= cursor:
                    break
                path.appendleft(point)
            if path:
                found['path'] = list(path)
            return self._number, found
