"""Images of the simulation for those who watch."""
import threading

import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.nodes import image_msgs, robot_msgs
from img_recog.simulation.scene import Scene, poses_of
from img_recog.simulation.settings import SimulationError, ViewSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.view import View

_FRAME = 'view'                 # no frame of tf: the camera is none of the robot's
_LOOK_UP_S = 0.1
_PATIENCE_S = 2.0               # with an image that is being drawn


class ViewTopic:
    """Publishes ~view/image_raw (sensor_msgs/Image, rgb8) while somebody subscribes to it."""

    def __init__(self, scene: Scene, settings: ViewSettings):
        self._view = View(scene, settings)
        self._images = rospy.Publisher('~view/image_raw', Image, queue_size=1)
        self._asked = threading.Event()
        self._broken = False
        self._publisher = threading.Thread(target=self._publish, daemon=True)
        self._publisher.start()

    def update(self, simulator: Simulator) -> None:
        """Call in the loop: have an image drawn if one is wanted and it is time for it."""
        if not self._broken and self._images.get_num_connections() and self._view.due():
            try:
                self._view.request(poses_of(simulator), simulator.time_s)
            except OSError:
                pass            # that process has ended; taking the image tells
            self._asked.set()

    def _publish(self) -> None:
        while not rospy.is_shutdown():
            if not self._asked.wait(_LOOK_UP_S):
                continue
            self._asked.clear()
            try:
                image = self._view.next_image()
            except SimulationError as error:
                self._broken = True
                if not rospy.is_shutdown():
                    rospy.logwarn('no more view: %s; the simulation goes on without', error)
                return
            header = Header(stamp=robot_msgs.stamp_of(image.time_s), frame_id=_FRAME)
            self._images.publish(image_msgs.to_msg(image.pixels, 'rgb8', header))

    def close(self) -> None:
        """End the process that draws."""
        self._broken = True
        # it may be reading an image from what is closed next
        self._publisher.join(_PATIENCE_S)
        self._view.close()
