"""Runs all frames of a recording, or of a camera on the robot, through recognition and robot."""
from typing import TYPE_CHECKING, Iterable, List, Protocol, Sequence

from img_recog.replay.chain import Chain, Frame, FrameMeasurement, Recognition, Recorder
from img_recog.replay.inputs import prefetch

if TYPE_CHECKING:
    from img_recog.simulation.simulator import Simulator

_PREFETCHED_FRAMES = 8


class Frames(Protocol):
    """Frames in the order of time.

    expected: how many, 0 if unknown; period_ns: how long the last one is shown, known after it;
    warnings: messages for the user, complete after the last frame.
    """

    expected: int
    period_ns: int
    warnings: List[str]

    def __iter__(self):
        """Yield each Frame."""


class Loop:
    """A chain and its frames.

    measurements: of the frames, those of a recording ahead of the chain; to be passed to `run`.
    """

    def __init__(self, simulator: 'Simulator', frames: Frames, recognition: Recognition,
                 teleop: bool, recorders: Sequence[Recorder]):
        """Arguments as for Chain."""
        self._frames, self._chain = frames, Chain(simulator, recognition, teleop, recorders)
        self.measurements: Iterable[FrameMeasurement] = recognition.measure(self._followed())
        if not hasattr(frames, 'follow'):
            self.measurements = prefetch(self.measurements, _PREFETCHED_FRAMES)

    def _followed(self) -> Iterable[Frame]:
        if hasattr(self._frames, 'follow'):     # what they show depends on the commands before
            self._frames.follow(self._chain.simulate_until)
        return self._frames

    def run(self, measurements: Iterable[FrameMeasurement]) -> int:
        """Run frames up to the end of the last one; return its time in ns."""
        last_ns = self._chain.run(measurements)
        end_ns = last_ns + self._frames.period_ns       # that of a bag is not known earlier
        self._chain.end(end_ns)
        return end_ns
