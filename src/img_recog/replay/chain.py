"""Frames to areas to commands to a simulated robot, in simulated time and without a master.

Time is counted in nanoseconds from the first frame, so that nothing adds up; what happens at a
time happens at the step of the physics that is nearest to it.
"""
import math
from typing import Any, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import STOP, Command, Commander
from img_recog.recognition.settings import RecognitionSettings
from img_recog.simulation.body import Motion
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Reading

SECOND_NS = 10 ** 9
RECOGNITION, TELEOP = 'recognition', 'teleop'
_TELEOP_NS = SECOND_NS // 10    # the idle teleop sends zeros at 10 Hz
_LOOK_UP_NS = SECOND_NS // 10   # so long the recognition waits for a frame at a time


class Frame(NamedTuple):
    """An image and when it was taken.

    number: from 0; stamp_ns: on the clock of whoever took it; header: std_msgs/Header that goes
    with it; image: uint8 of shape (height, width, 3 or 4), of one of areas.ENCODINGS.
    """

    number: int
    stamp_ns: int
    header: Any
    image: np.ndarray
    encoding: str


class FrameMeasurement(NamedTuple):
    """A frame, and the area and the centroid (x, y in pixels, or None) of each color in it."""

    frame: Frame
    areas_px: List[int]
    centroids: List[Optional[Tuple[float, float]]]


class FrameResult(NamedTuple):
    """What came of a frame.

    areas_px, centroids (x, y in pixels, or None): of each color; commands: those given for it;
    motion: of the robot's root link when the frame came.
    """

    frame: Frame
    time_ns: int
    areas_px: List[int]
    centroids: List[Optional[Tuple[float, float]]]
    commands: List[Command]
    motion: Motion


class CommandSent(NamedTuple):
    """A command for the robot; sender: RECOGNITION or TELEOP."""

    time_ns: int
    command: Command
    sender: str


class Recorder:
    """Is told all that happens, in the order of time; notes nothing."""

    def start(self, stamp_ns: int) -> None:
        """Note the stamp of the first frame, which is time 0."""

    def on_frame(self, seen: FrameResult) -> None:
        """Note a frame; its commands come next, by `sent`."""

    def on_command(self, sent: CommandSent) -> None:
        """Note a command."""

    def on_reading(self, reading: Reading) -> None:
        """Note what a sensor of the robot saw."""


def measured(frames: Iterable[Frame], settings: RecognitionSettings) -> Iterator[FrameMeasurement]:
    """Yield the frames measured; nothing of the chain is needed for it, so it may go ahead."""
    extractor, colors = ColorExtractor(settings), range(len(settings.colors))
    for frame in frames:
        areas_px = extractor.measure(frame.image, frame.encoding)
        yield FrameMeasurement(frame, areas_px, [extractor.centroid(number) for number in colors])


class Chain:
    """Runs measured frames through the decisions of the recognition and the simulation."""

    def __init__(self, simulator: Simulator, settings: RecognitionSettings, teleop: bool,
                 recorders: Sequence[Recorder]):
        """Drive the first vehicle of `simulator`, which must not have been advanced yet.

        teleop: whether zeros are sent at 10 Hz, as the idle teleop does; at the time of a frame
        they are sent just before its commands.
        """
        self._simulator, self._vehicle = simulator, simulator.vehicles[0]
        self._step_ns = round(simulator.world.step_s * SECOND_NS)
        self._steps = 0
        self._recorders = recorders
        self._commander = Commander(settings, 0.0)
        self._teleop_ns = 0 if teleop else math.inf
        self._look_up_ns = _LOOK_UP_NS

    def run(self, frames: Iterable[FrameMeasurement]) -> int:
        """Run all frames, and return the time of the last in ns, 0 without any."""
        time_ns, start_ns = 0, None
        for found in frames:
            frame = found.frame
            if start_ns is None:
                start_ns = frame.stamp_ns
                for recorder in self._recorders:
                    recorder.start(start_ns)
            time_ns = frame.stamp_ns - start_ns
            self.simulate_until(time_ns)
            self._process_frame(found, time_ns)
        return time_ns

    def simulate_until(self, until_ns: int) -> None:
        """Simulate until a time, with what is sent while no frame comes."""
        while True:
            # at the time itself a frame has come, and nobody waits any longer
            waiting = self._look_up_ns if self._look_up_ns < until_ns else math.inf
            due_ns = min(self._teleop_ns, waiting)
            if due_ns > until_ns:
                break
            self._advance(due_ns)
            if due_ns == self._teleop_ns:
                self._teleop_ns += _TELEOP_NS
                self._send(due_ns, [STOP], TELEOP)
            else:
                self._look_up_ns += _LOOK_UP_NS
                self._send(due_ns, self._commander.wait(due_ns / SECOND_NS), RECOGNITION)
        self._advance(until_ns)

    def end(self, time_ns: int) -> None:
        """Let the time of the last frame pass and the recognition end."""
        self.simulate_until(time_ns - 1)
        self._advance(time_ns)
        self._send(time_ns, self._commander.end(), RECOGNITION)

    def _process_frame(self, found: FrameMeasurement, time_ns: int) -> None:
        commands = self._commander.decide(found.areas_px, time_ns / SECOND_NS)
        seen = FrameResult(found.frame, time_ns, found.areas_px, found.centroids, commands,
                           self._vehicle.robot.motion())
        for recorder in self._recorders:
            recorder.on_frame(seen)
        self._send(time_ns, commands, RECOGNITION)
        self._look_up_ns = time_ns + _LOOK_UP_NS

    def _send(self, time_ns: int, commands: Iterable[Command], sender: str) -> None:
        for command in commands:
            self._vehicle.command(*command)
            for recorder in self._recorders:
                recorder.on_command(CommandSent(time_ns, command, sender))

    def _advance(self, time_ns: int) -> None:
        steps = (time_ns + self._step_ns // 2) // self._step_ns
        readings = self._simulator.advance(max(0, steps - self._steps))
        self._steps = max(steps, self._steps)
        for reading in readings:
            for recorder in self._recorders:
                recorder.on_reading(reading)
