"""Records the data for the picture of a replay."""
from typing import Dict, List, Sequence

import numpy as np

from img_recog.recognition.settings import Color
from img_recog.replay.chain import (RECOGNITION, SECOND_NS, TELEOP, CommandSent, FrameResult,
                                    Recorder)
from img_recog.replay.plot_data import PlotData


class PlotRecorder(Recorder):
    """Collects the data that is drawn at the end of a replay.

    frames: number of frames so far.
    """

    def __init__(self, colors: Sequence[Color]):
        self._colors = colors
        self._rows: List[tuple] = []
        self._sent: Dict[str, List[tuple]] = {RECOGNITION: [], TELEOP: []}

    @property
    def frames(self) -> int:
        return len(self._rows)

    def on_frame(self, result: FrameResult) -> None:
        motion = result.motion
        self._rows.append((result.time_ns / SECOND_NS, motion.position[0], motion.position[1],
                           motion.yaw, motion.linear[0], motion.angular[2], *result.areas_px))

    def on_command(self, sent: CommandSent) -> None:
        self._sent[sent.sender].append((sent.time_ns / SECOND_NS, *sent.command))

    def data(self, end_s: float, outlines: Sequence[np.ndarray]) -> PlotData:
        """Return the collected data; end_s, outlines: as in PlotData."""
        return PlotData(self._colors, np.array(self._rows), self._commands(RECOGNITION),
                        self._commands(TELEOP), end_s, outlines)

    def _commands(self, sender: str) -> np.ndarray:
        return np.array(self._sent[sender]).reshape(-1, 3)
