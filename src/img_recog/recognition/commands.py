"""Areas to commands."""
from typing import List, NamedTuple, Optional, Sequence

from img_recog.recognition.settings import RecognitionSettings


class Command(NamedTuple):
    """What is asked of the robot: linear_x in m/s, angular_z in rad/s."""

    linear_x: float
    angular_z: float = 0.0


STOP = Command(0.0)


def commands(areas_px: Sequence[int], settings: RecognitionSettings) -> List[Command]:
    """Return the command of each color whose area is above its limit, in the settings' order.

    areas_px: one area a color. No color in view gives no command at all: stopping is left to
    whoever else commands the robot (in the article, the idle teleop), or to a Commander.
    """
    return [Command(color.linear_x, color.angular_z)
            for color, area_px in zip(settings.colors, areas_px)
            if area_px > color.area_limit_px]


class Commander:
    """Decides from frame to frame, and in between, what to publish.

    Times are seconds of one steady clock.
    """

    def __init__(self, settings: RecognitionSettings, now_s: float):
        self._settings = settings
        self._last: Optional[List[Command]] = None
        self._seen_s, self._is_stopped = now_s, False

    def configure(self, settings: RecognitionSettings) -> None:
        """Decide by these settings from now on."""
        self._settings = settings

    def decide(self, areas_px: Sequence[int], now_s: float) -> List[Command]:
        """Return what to publish for a frame with these areas."""
        found = commands(areas_px, self._settings)
        is_new, self._last = found != self._last, found
        if found:
            self._seen_s, self._is_stopped = now_s, False
        if is_new or not self._settings.publish_on_change:
            return found + self.wait(now_s)
        return self.wait(now_s)

    def wait(self, now_s: float) -> List[Command]:
        """Return what to publish while no frame comes: STOP, once, when colors are lost."""
        limit_s = self._settings.stop_when_lost
        if self._is_stopped or limit_s == 0 or now_s - self._seen_s < limit_s:
            return []
        # the color that is seen next is news, though it may be the last one
        self._is_stopped, self._last = True, None
        return [STOP]

    def end(self) -> List[Command]:
        """Return what to publish when the node ends."""
        return [STOP] if self._settings.stop_when_lost else []
