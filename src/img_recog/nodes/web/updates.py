"""What is new since the last message to a page. Independent of ROS."""
import threading
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Tuple

MAX_STATES = 300
_MAX_EVENTS = 400       # of a kind; about 10 s of a demo


class Updates:
    """Events, of which each is sent once, and states, of which only the last counts.

    A cursor is the number of the last change that somebody got. All methods may be called by any
    thread. Values are what JSON knows, without NaN.

    >>> updates = Updates()
    >>> updates.add('log', 'hello')
    >>> cursor, found = updates.since(None)
    >>> found
    {'log': ['hello']}
    >>> updates.set('factor', 0.5), updates.set('factor', 1.0)
    (True, True)
    >>> updates.since(cursor)[1]
    {'factor': 1.0}
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._number = 0
        self._events: Dict[Tuple[str, str], Deque[Tuple[int, Any]]] = {}     # by kind and part
        self._states: Dict[str, Tuple[int, Any]] = {}

    def add(self, kind: str, value: Any, most: int = _MAX_EVENTS, part: str = '') -> None:
        """Add an event; most: how many of this kind are kept, of each part that it has."""
        with self._lock:
            self._number += 1
            self._events.setdefault((kind, part), deque(maxlen=most)).append(
                (self._number, value))

    def set(self, kind: str, value: Any) -> bool:
        """Set a state; return False if there are too many already."""
        with self._lock:
            is_known = kind in self._states or len(self._states) < MAX_STATES
            if is_known:
                self._number += 1
                self._states[kind] = self._number, value
            return is_known

    def clear(self) -> None:
        """Forget everything: what was measured before is no start of what follows."""
        with self._lock:
            self._events.clear()
            self._states.clear()

    def since(self, cursor: Optional[int]) -> Tuple[int, Dict[str, Any]]:
        """Return the cursor of the last change, and what came after `cursor`; None for all.

        Events as lists by their kind, and states by their kind.
        """
        cursor = cursor or 0
        with self._lock:
            found = {kind: value for kind, (number, value) in self._states.items()
                     if number > cursor}
            newer: Dict[str, List[Tuple[int, Any]]] = {}
            for (kind, _), events in self._events.items():
                for event in reversed(events):
                    if event[0] <= cursor:
                        break
                    newer.setdefault(kind, []).append(event)
            for kind, others in newer.items():
                found[kind] = [value for _, value in sorted(others, key=lambda event: event[0])]
            return self._number, found
