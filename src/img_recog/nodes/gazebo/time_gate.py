"""Whether simulated time may pass."""
import enum
import math
import threading
import time
from typing import Any, Callable, Collection, Dict, Optional, Set

import rospy

from img_recog.errors import SimulationError

_REPORT_PERIOD_S = 5.0      # of wall time


class Mode(enum.Enum):
    """How the user lets simulated time pass."""

    PAUSED = 'paused'
    STEP_THEN_PAUSE = 'until a call of ~step is over, then paused'
    STEP_THEN_RUN = 'until a call of ~step is over, then running'
    RUNNING = 'running'
    SHUT_DOWN = 'never again'


_NOT_PAUSED = ('the physics is not paused',
               'call ~pause_physics first, or start with paused:=true')
_STILL_STEPPING = 'another call of ~step has not ended', 'wait for its response'
_STEPPING = Mode.STEP_THEN_PAUSE, Mode.STEP_THEN_RUN
# the next mode after an event, by the mode before; in all other modes, the event changes nothing
_TRANSITIONS = {
    'pause': {Mode.RUNNING: Mode.PAUSED, Mode.STEP_THEN_RUN: Mode.STEP_THEN_PAUSE},
    'unpause': {Mode.PAUSED: Mode.RUNNING, Mode.STEP_THEN_PAUSE: Mode.STEP_THEN_RUN},
    'step': {Mode.PAUSED: Mode.STEP_THEN_PAUSE},
    'end_step': {Mode.STEP_THEN_PAUSE: Mode.PAUSED, Mode.STEP_THEN_RUN: Mode.RUNNING},
    'shut_down': dict.fromkeys(Mode, Mode.SHUT_DOWN),
}


class Wait(enum.Enum):
    """What simulated time can wait for, in the order in which the log names it.

    The value is the text of the log. All but LOADING are for lockstep alone. A wait begins with
    `expect`, and ends when nothing of what it expects is left:

    ===========  ===============================  ============================================
    wait         begins when                      ends when
    ===========  ===============================  ============================================
    LOADING      there are cameras, and the       it has loaded, or cannot draw; without
                 process that draws has not       lockstep, it never begins once time has passed
                 loaded the world
    IMAGES       cameras have taken an image      it is drawn, or never can be
    CONNECTIONS  lockstep starts                  all nodes that answer are connected
    SENSOR       no sensor is to be answered      there is one, and it is used
    ANSWERS      the messages to answer are made  each topic has its answer; `timeout_s` after
                                                  the messages were sent; its robot is removed
    ===========  ===============================  ============================================
    """

    LOADING = 'the process that draws to load {}'
    IMAGES = 'the process that draws to draw the images of the cameras'
    CONNECTIONS = '{}'
    SENSOR = 'a sensor of the kind {}; no robot has one, or no node subscribes to the images'
    ANSWERS = 'a message on {}'


class TimeGate:
    """Decides whether simulated time may pass: if the mode lets it, and nothing is awaited.

    All methods are for any thread: `_lock` is that of all attributes.
    """

    def __init__(self, mode: Mode, wake: Callable[[], None], timeout_s: Optional[float] = None):
        """Wait for nothing.

        Args:
            mode: First mode.
            wake: Function that is called when the last wait ends by `end`.
            timeout_s: Wall time in s that ANSWERS may last, None without lockstep.
        """
        self._lock = threading.RLock()
        self._mode, self._wake, self._timeout_s = mode, wake, timeout_s
        # steps of the physics at which time stops in this mode, and at which a call of ~step ends
        self._end = math.inf if mode is Mode.RUNNING else 0
        self._step_end, self._end_call = 0, _do_nothing
        self._awaited: Dict[Wait, Set[Any]] = {}
        # by time.monotonic(): the last time at which time could pass, None before the first; when
        # the messages to answer were sent, or a pause after that ended; and the last report
        self._passed_s: Optional[float] = None
        self._sent_s: Optional[float] = None
        self._reported_s = time.monotonic()

    @property
    def mode(self) -> Mode:
        """The mode."""
        with self._lock:
            return self._mode

    @property
    def is_paused(self) -> bool:
        """Whether time passes only by calls of ~step."""
        return self.mode in (Mode.PAUSED, Mode.STEP_THEN_PAUSE)

    def step(self, end: int, end_call: Callable[[], None]) -> None:
        """Let time pass while paused.

        Args:
            end: Step of the physics at which time stops.
            end_call: Function that is called when that time has passed, was reset, or never will.

        Raises:
            SimulationError: if time is not paused, or another call has not ended.
        """
        with self._lock:
            if self._mode is not Mode.PAUSED:
                raise SimulationError(*(_STILL_STEPPING if self.is_paused else _NOT_PAUSED))
            self._step_end, self._end_call = end, end_call
            self.change('step')

    def change(self, event: str) -> None:
        """Let one of the events of _TRANSITIONS happen.

        `end_step` is for when the time of the call of ~step has passed, or is reset. `shut_down`
        ends all waits, too.
        """
        with self._lock:
            before = self._mode
            self._mode = _TRANSITIONS[event].get(before, before)
            self._end = math.inf if self._mode is Mode.RUNNING else (
                self._step_end if self._mode in _STEPPING else 0)
            if before is Mode.PAUSED and self._sent_s is not None:
                self._sent_s = time.monotonic()     # a pause does not count for the timeout
            if self._mode is Mode.SHUT_DOWN:
                self._awaited = {}
            end_call = _do_nothing
            if event in ('end_step', 'shut_down'):
                end_call, self._end_call = self._end_call, end_call
        end_call()

    def expect(self, wait: Wait, what: Collection[Any]) -> None:
        """Begin a wait for all of some things, whose texts name them; for none, end it.

        The timeout of ANSWERS begins with `notify_sent`.
        """
        with self._lock:
            self._awaited.pop(wait, None)
            if what and self.holds(wait):
                self._awaited[wait] = set(what)
            if wait is Wait.ANSWERS:
                self._sent_s = None

    def holds(self, wait: Wait) -> bool:
        """Return whether time would wait, if such a wait began now."""
        with self._lock:
            return self._mode is not Mode.SHUT_DOWN and (self._timeout_s is not None or (
                wait is Wait.LOADING and self._passed_s is None))

    def notify_sent(self) -> None:
        """Call before the messages to answer are sent; later calls change nothing."""
        with self._lock:
            if self._sent_s is None:
                self._sent_s = time.monotonic()

    def end(self, wait: Wait, *what: Any) -> None:
        """Wait no longer for some things; it does not matter whether they are awaited."""
        with self._lock:
            left = self._awaited.get(wait, set())
            is_last = bool(left) and left.issubset(what) and len(self._awaited) == 1
            left.difference_update(what)
            if not left:
                self._awaited.pop(wait, None)
        if is_last:
            self._wake()

    def awaited(self, *waits: Wait) -> Set[Any]:
        """Return what is left of some waits."""
        with self._lock:
            return set().union(*(self._awaited.get(wait, ()) for wait in waits))

    @property
    def is_sent(self) -> bool:
        """Whether the messages to answer are sent."""
        with self._lock:
            return self._sent_s is not None

    def overdue(self) -> Set[Any]:
        """Return the answers that have not come in time."""
        with self._lock:
            is_late = (self._timeout_s is not None and self._sent_s is not None
                       and time.monotonic() >= self._sent_s + self._timeout_s)
            return self.awaited(Wait.ANSWERS) if is_late else set()

    def may_pass(self, steps: int) -> bool:
        """Return whether time may pass now, which is `steps` steps of the physics."""
        with self._lock:
            may_pass = not self._awaited and steps < self._end
            if may_pass:
                self._passed_s = time.monotonic()
            return may_pass

    def end_of(self, end: int) -> int:
        """Return the step of the physics at which time must stop, at most `end`."""
        with self._lock:
            return int(min(end, self._end))

    def is_step_over(self, steps: int) -> bool:
        """Return whether the time of a call of ~step has passed, and nothing is awaited."""
        with self._lock:
            return self._mode in _STEPPING and steps >= self._step_end and not self._awaited

    def report(self, time_s: float) -> None:
        """Log what is awaited, at most every 5 s of wall time; time_s: the simulated time."""
        with self._lock:
            now_s, begin_s = time.monotonic(), max(
                self._reported_s, self._passed_s or 0.0, self._sent_s or 0.0)
            wait = next((each for each in Wait if each in self._awaited), None)
            if (wait is None or self._mode is Mode.PAUSED
                    or now_s < begin_s + _REPORT_PERIOD_S):
                return
            self._reported_s = now_s
            text = wait.value.format('; '.join(sorted(map(str, self._awaited[wait]))))
        rospy.logwarn('simulation paused: waiting for %s (simulated time is %.3f s)', text, time_s)


def _do_nothing() -> None:
    """Stand for a call of ~step, where there is none."""
