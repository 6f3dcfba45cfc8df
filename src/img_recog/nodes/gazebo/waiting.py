"""For whom simulated time stands: for images at the start, and in lockstep for other nodes."""
import time
from typing import Optional, Sequence

import rospy

from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.model_topics import WorldTopics
from img_recog.nodes.gazebo.standing_report import StandingReport
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.simulated_model import Reading
from img_recog.simulation.sensors.robot_camera import CAMERA

_POLL_S = 0.0001


class Waiting:
    """Tells the loop when time must stand, and when commands are due.

    Without lockstep, time only stands at the start, until the images of cameras can be drawn, and
    commands are always due. All methods are for the thread that simulates.
    """

    def __init__(self, simulator: Simulator, images: Images, topics: WorldTopics,
                 lockstep: Optional[Lockstep]):
        self._simulator, self._images, self._topics = simulator, images, topics
        self._lockstep = lockstep
        self._has_begun, self._is_reset = False, False
        self._report = StandingReport()
        self._is_due = lockstep is None

    def must_stand(self) -> bool:
        """Return whether time must stand now.

        Raises UserError when no answer came, and the node is to end then.
        """
        if (self._lockstep is not None or not self._has_begun) and self._images.is_loading():
            self._report(self._simulator.time_s, 'the process that draws to load the world')
            return True
        if self._lockstep is None:
            self._has_begun = True
            return False
        if not self._images.are_drawn():
            return True
        self._lockstep.notify_sent()        # also of images that can never be drawn
        if self._lockstep.waits(self._simulator.time_s):
            return True
        self._images.enable_cameras()
        if self._simulator.next_reading(self._lockstep.kinds) is None:
            self._report(self._simulator.time_s, 'a sensor that is answered; no robot has one, or '
                         'nobody subscribes to the images')
            return True
        return False

    def take_commands(self) -> bool:
        """Return whether commands are due: in lockstep, once after the answers."""
        if self._lockstep is not None and not self._is_due:
            return False
        if self._is_reset:      # they are out of date
            self._topics.discard_commands()
        self._is_due = self._is_reset = False
        return True

    def discard_commands(self) -> None:
        """Drop the commands that were not applied yet, and in lockstep those that will answer."""
        self._topics.discard_commands()
        self._is_reset = self._lockstep is not None and self._is_due

    def restart(self) -> None:
        """Let the time without an answer begin now, as after a pause."""
        if self._lockstep is not None:
            self._lockstep.restart()

    def end_of(self, end: int) -> int:
        """Return the step at which to stop, at most `end`: where answers are expected."""
        if self._lockstep is None:
            return end
        step = self._simulator.next_reading(self._lockstep.kinds)
        return end if step is None else min(end, step)

    def finish(self) -> None:
        """Call before anything else is published: in lockstep, waits for the images before.

        An image can be answered while the thread that publishes it has not ended yet: it may wait
        for the processor that the answering node uses.
        """
        while (self._lockstep is not None and not self._images.is_complete()
               and not rospy.is_shutdown()):
            time.sleep(_POLL_S)

    def expect(self, readings: Sequence[Reading]) -> None:
        """Call before readings are published."""
        if self._lockstep is None:
            return
        answered = [each for each in readings if each.kind in self._lockstep.kinds]
        if not answered:
            return
        self._is_due = True
        self._lockstep.expect(
            answered[-1].time_s, self._topics.namespaces({each.robot for each in answered}),
            self._topics.namespaces())
        if all(each.kind != CAMERA for each in answered):
            self._lockstep.notify_sent()
