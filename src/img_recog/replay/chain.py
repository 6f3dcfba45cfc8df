"""Runs frames through recognition, commands and simulated robot, in simulated time.

Times are integers in nanoseconds from the first frame, so that rounding errors do not accumulate.
An event takes effect at the physics step nearest to its time.
"""
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import (TYPE_CHECKING, Any, Iterable, Iterator, List, NamedTuple, Optional, Sequence,
                    Tuple, TypeVar)

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import POLL_PERIOD_S, STOP, Command, Commander
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings.frames import SECOND_NS, Frame, Frames
from img_recog.teleoperation import PERIOD_S

if TYPE_CHECKING:       # they import PyBullet, which film.py does not need
    from img_recog.simulation.physics.body import Motion
    from img_recog.simulation.simulator import Simulator
    from img_recog.simulation.simulated_model import Reading

RECOGNITION, TELEOP = 'recognition', 'teleop'
_TELEOP_PERIOD_NS = round(PERIOD_S * SECOND_NS)
_POLL_PERIOD_NS = round(POLL_PERIOD_S * SECOND_NS)
_NEVER_NS = 1 << 63
_PREFETCHED_FRAMES = 8
_END: Any = object()     # after the last item
Item = TypeVar('Item')


class FrameMeasurement(NamedTuple):
    """A frame, and the area and the centroid (x, y in pixels, or None) of each color in it.

    Without colors, both lists are empty.
    """

    frame: Frame
    areas_px: List[int]
    centroids: List[Optional[Tuple[float, float]]]


class FrameResult(NamedTuple):
    """The result of a frame.

    time_ns: simulated time of the frame; areas_px, centroids (x, y in pixels, or None): of each
    color; commands: published for the frame; motion: of the robot's root link at time_ns.
    """

    frame: Frame
    time_ns: int
    areas_px: List[int]
    centroids: List[Optional[Tuple[float, float]]]
    commands: List[Command]
    motion: 'Motion'


class CommandSent(NamedTuple):
    """A command published for the robot; sender: RECOGNITION or TELEOP."""

    time_ns: int
    command: Command
    sender: str


class Recorder:
    """Base class of recorders: is notified of all events in the order of time and ignores them."""

    def start(self, stamp_ns: int) -> None:
        """Handle the start; stamp_ns: stamp of the first frame, whose time is 0."""

    def on_frame(self, result: FrameResult) -> None:
        """Handle a frame; `on_command` follows for each of its commands."""

    def on_command(self, sent: CommandSent) -> None:
        """Handle a command."""

    def on_reading(self, reading: 'Reading') -> None:
        """Handle the reading of a sensor of the robot."""


class Recognition:
    """Base class of what decides on commands: measures no color, and decides on none.

    warnings: messages for the user, complete after the last frame.
    """

    def __init__(self) -> None:
        self.warnings: List[str] = []

    def measure(self, frames: Iterable[Frame]) -> Iterator[FrameMeasurement]:
        """Measure frames; independent of the chain, so it may run ahead of it."""
        return (FrameMeasurement(frame, [], []) for frame in frames)

    def decide(self, measurement: FrameMeasurement, time_s: float) -> List[Command]:
        """Return what to publish for a frame; time_s: since the first one."""
        return []

    def wait(self, time_s: float) -> List[Command]:
        """Return what to publish while no frame arrives."""
        return []

    def end(self) -> List[Command]:
        """Return what to publish after the last frame."""
        return []


class ColorRecognition(Recognition):
    """Decides on commands by the areas of colors, as the node color_extract does."""

    def __init__(self, settings: RecognitionSettings):
        super().__init__()
        self._settings, self._commander = settings, Commander(settings, 0.0)

    def measure(self, frames: Iterable[Frame]) -> Iterator[FrameMeasurement]:
        extractor, colors = ColorExtractor(self._settings), range(len(self._settings.colors))
        for frame in frames:
            areas_px = extractor.measure(frame.image, frame.encoding)
            yield FrameMeasurement(frame, areas_px,
                                   [extractor.centroid(number) for number in colors])

    def decide(self, measurement: FrameMeasurement, time_s: float) -> List[Command]:
        return self._commander.decide(measurement.areas_px, time_s)

    def wait(self, time_s: float) -> List[Command]:
        return self._commander.wait(time_s)

    def end(self) -> List[Command]:
        return self._commander.end()


class Chain:
    """Decides on the commands of measured frames and drives a simulated robot by them."""

    def __init__(self, simulator: 'Simulator', recognition: Recognition, teleop: bool,
                 recorders: Sequence[Recorder]):
        """Drive the first robot of `simulator`, which must not have been advanced yet.

        recognition: the one that has measured the frames.
        teleop: whether to send zeros, like the idle teleop; at the time of a frame they
        are sent just before its commands.
        """
        self._simulator, (self._robot,) = simulator, simulator.robots
        self._step_ns = round(simulator.world.step_s * SECOND_NS)
        self._steps = 0
        self._recorders = recorders
        self._recognition = recognition
        self._next_teleop_ns = 0 if teleop else _NEVER_NS
        self._next_poll_ns = _POLL_PERIOD_NS

    def measured(self, frames: Frames) -> Iterable[FrameMeasurement]:
        """Return the frames for `run`; those of a recording are measured ahead of it."""
        if hasattr(frames, 'follow'):       # what they show depends on the commands before
            frames.follow(self.simulate_until)
            return self._recognition.measure(frames)
        return prefetch(self._recognition.measure(frames), _PREFETCHED_FRAMES)

    def run(self, frames: Iterable[FrameMeasurement]) -> int:
        """Run all frames; return the time of the last one in ns, 0 if there are none."""
        time_ns, start_ns = 0, None
        for measurement in frames:
            frame = measurement.frame
            if start_ns is None:
                start_ns = frame.stamp_ns
                for recorder in self._recorders:
                    recorder.start(start_ns)
            time_ns = frame.stamp_ns - start_ns
            self.simulate_until(time_ns)
            self._process_frame(measurement, time_ns)
        return time_ns

    def simulate_until(self, until_ns: int) -> None:
        """Simulate until a time, with the commands that are sent while no frame arrives."""
        while True:
            # at until_ns itself a frame arrives, so the recognition no longer waits for one
            poll_ns = self._next_poll_ns if self._next_poll_ns < until_ns else _NEVER_NS
            due_ns = min(self._next_teleop_ns, poll_ns)
            if due_ns > until_ns:
                break
            self._advance(due_ns)
            if due_ns == self._next_teleop_ns:
                self._next_teleop_ns += _TELEOP_PERIOD_NS
                self._send(due_ns, [STOP], TELEOP)
            else:
                self._next_poll_ns += _POLL_PERIOD_NS
                self._send(due_ns, self._recognition.wait(due_ns / SECOND_NS), RECOGNITION)
        self._advance(until_ns)

    def end(self, time_ns: int) -> None:
        """Simulate until the end of the last frame and shut the recognition down."""
        self.simulate_until(time_ns - 1)
        self._advance(time_ns)
        self._send(time_ns, self._recognition.end(), RECOGNITION)

    def _process_frame(self, measurement: FrameMeasurement, time_ns: int) -> None:
        commands = self._recognition.decide(measurement, time_ns / SECOND_NS)
        result = FrameResult(measurement.frame, time_ns, measurement.areas_px,
                             measurement.centroids, commands, self._robot.body.motion())
        for recorder in self._recorders:
            recorder.on_frame(result)
        self._send(time_ns, commands, RECOGNITION)
        self._next_poll_ns = time_ns + _POLL_PERIOD_NS

    def _send(self, time_ns: int, commands: Iterable[Command], sender: str) -> None:
        for command in commands:
            self._robot.command(*command)
            for recorder in self._recorders:
                recorder.on_command(CommandSent(time_ns, command, sender))

    def _advance(self, time_ns: int) -> None:
        steps = (time_ns + self._step_ns // 2) // self._step_ns
        readings = self._simulator.advance(max(0, steps - self._steps))
        self._steps = max(steps, self._steps)
        for reading in readings:
            for recorder in self._recorders:
                recorder.on_reading(reading)


def prefetch(items: Iterable[Item], depth: int) -> Iterator[Item]:
    """Yield the same items in the same order, of which a thread makes up to `depth` ahead.

    An exception raised by `items` is raised at the same place.
    """
    advance = partial(next, iter(items), _END)
    with ThreadPoolExecutor(1) as pool:
        pending = deque(pool.submit(advance) for _ in range(depth))
        while True:
            item = pending.popleft().result()
            if item is _END:
                return
            pending.append(pool.submit(advance))
            yield item
