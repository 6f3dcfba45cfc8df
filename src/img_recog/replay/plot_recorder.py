"""What is kept of a replay for its picture."""
from typing import Dict, List, Sequence

import numpy as np

from img_recog.recognition.settings import Color
from img_recog.replay.chain import (RECOGNITION, SECOND_NS, TELEOP, CommandSent, FrameResult,
                                    Recorder)
from img_recog.replay.plot_data import PlotData


class PlotRecorder(Recorder):
    """Keeps what is drawn at the end: some numbers a frame.

    frames: how many have been seen.
    """

    def __init__(self, colors: Sequence[Color]):
        self._colors = colors
        self._rows: List[tuple] = []
        self._sent: Dict[str, List[tuple]] = {RECOGNITION: [], TELEOP: []}

    @property
    def frames(self) -> int:
        return len(self._rows)

    def on_frame(self, seen: FrameResult) -> None:
        motion = seen.motion
        self._rows.append((seen.time_ns / SECOND_NS, motion.position[0], motion.position[1],
                           motion.yaw, motion.linear[0], motion.angular[2], *seen.areas_px))

    def on_command(self, sent: CommandSent) -> None:
        self._sent[sent.sender].append((sent.time_ns / SECOND_NS, *sent.command))

    def numbers(self, end_s: float, outlines: Sequence[np.ndarray]) -> PlotData:
        """Return what has been kept; end_s, outlines: as PlotData has them."""
        return PlotData(self._colors, np.array(self._rows),
                        *(np.array(self._sent[sender]).reshape(-1, 3)
                          for sender in (RECOGNITION, TELEOP)), end_s, outlines)
