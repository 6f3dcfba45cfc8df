"""Velocity commands from the areas of colors."""
from typing import List, NamedTuple, Optional, Sequence

from img_recog.recognition.recognition_settings import LAST, SUM, RecognitionSettings

POLL_PERIOD_S = 0.1     # how often it is looked whether the colors are lost


class Command(NamedTuple):
    """A velocity command for the robot: linear_x and linear_y in m/s, angular_z in rad/s."""

    linear_x: float
    angular_z: float = 0.0
    linear_y: float = 0.0


STOP = Command(0.0)


def commands_for(areas_px: Sequence[int], settings: RecognitionSettings) -> List[Command]:
    """Return the command of each color whose area is above its limit, in the settings' order.

    With publish_commands last or sum, these are one command. areas_px: the area of each color in
    pixels. If no color is above its limit, there is no command at all: stopping the robot is left
    to another node (in the article, the idle teleoperation) or to a Commander.

    >>> from img_recog.recognition.recognition_settings import with_colors
    >>> commands_for([1001, 1000], with_colors(['blue', 'red'])())
    [Command(linear_x=10.0, angular_z=0.0, linear_y=0.0)]
    """
    commands = [Command(color.linear_x, color.angular_z)
                for color, area_px in zip(settings.colors, areas_px)
                if area_px > color.area_limit_px]
    if settings.publish_commands == LAST:
        return commands[-1:]
    if settings.publish_commands == SUM and commands:
        return [Command(*map(sum, zip(*commands)))]
    return commands


class Commander:
    """Decides which commands to publish for each frame and while no frame arrives.

    All times are seconds of one monotonic clock.

    frame_commands: the commands for the colors in the newest frame, published or not.
    """

    def __init__(self, settings: RecognitionSettings, now_s: float):
        self._settings = settings
        self.frame_commands: List[Command] = []
        self._last_commands: Optional[List[Command]] = None
        self._last_seen_s, self._is_stopped = now_s, False

    def configure(self, settings: RecognitionSettings) -> None:
        """Use other settings from now on."""
        self._settings = settings

    def decide(self, areas_px: Sequence[int], now_s: float) -> List[Command]:
        """Return what to publish for a frame in which the colors have these areas."""
        self.frame_commands = frame_commands = commands_for(areas_px, self._settings)
        has_changed = frame_commands != self._last_commands
        self._last_commands = frame_commands
        if frame_commands:
            self._last_seen_s, self._is_stopped = now_s, False
        if has_changed or not self._settings.publish_on_change:
            return frame_commands + self.wait(now_s)
        return self.wait(now_s)

    def wait(self, now_s: float) -> List[Command]:
        """Return what to publish while no frame arrives: STOP, once, when the colors are lost."""
        timeout_s = self._settings.stop_when_lost
        if self._is_stopped or timeout_s == 0 or now_s - self._last_seen_s < timeout_s:
            return []
        # the next command is a change even if it is the same as before the stop
        self._is_stopped, self._last_commands = True, None
        return [STOP]

    def notify_dropped(self, commands: Sequence[Command]) -> None:
        """Call when commands were not published: they are due again."""
        self._last_commands = None
        if STOP in commands:
            self._is_stopped = False

    def end(self) -> List[Command]:
        """Return what to publish when the node shuts down."""
        return [STOP] if self._settings.stop_when_lost else []
