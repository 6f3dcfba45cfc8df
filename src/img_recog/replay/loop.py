"""Runs all frames of a recording, or of a camera on the robot, through recognition and robot."""
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any, Iterable, Iterator, Sequence, TypeVar

from img_recog.recordings.frames import Frame, Frames
from img_recog.replay.chain import Chain, FrameMeasurement, Recognition, Recorder

if TYPE_CHECKING:
    from img_recog.simulation.simulator import Simulator

_PREFETCHED_FRAMES = 8
_END: Any = object()     # after the last item
Item = TypeVar('Item')


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
