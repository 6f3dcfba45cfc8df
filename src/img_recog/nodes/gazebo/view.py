"""The image topic of the simulation."""
import threading

import rospy
from std_msgs.msg import Header

from img_recog.conversions import robot_msgs
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.simulation.scene import Scene, poses_of
from img_recog.simulation.settings import SimulationError, ViewSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.view import View, ViewImage

_FRAME = 'view'                 # not a frame of tf: the camera is not part of the robot
_POLL_PERIOD_S = 0.1


class ViewTopic:
    """Publishes ~view/image_raw (sensor_msgs/Image, rgb8) while it has a subscriber."""

    def __init__(self, scene: Scene, settings: ViewSettings):
        self._view = View(scene, settings)
        self._images = ImagePublisher('~view/image_raw')
        self._ended = threading.Event()
        self._publisher = threading.Thread(target=self._publish, daemon=True)
        self._publisher.start()

    def update(self, simulator: Simulator) -> None:
        """Request an image if there is a subscriber and it is time; to be called by the loop."""
        if (self._images.get_num_connections() and self._view.due()
                and not self._ended.is_set()):
            self._view.request(poses_of(simulator), simulator.time_s)

    def _publish(self) -> None:
        while not self._ended.is_set():
            try:
                image = self._view.next_image(_POLL_PERIOD_S)
            except SimulationError as error:
                self._ended.set()
                rospy.logwarn('no more view: %s; the simulation goes on without it', error)
                return
            if image is not None:
                self._publish_image(image)

    def _publish_image(self, image: ViewImage) -> None:
        header = Header(stamp=robot_msgs.stamp_of(image.time_s), frame_id=_FRAME)
        self._images.publish(image.pixels, 'rgb8', header)

    def close(self) -> None:
        """End the process that draws."""
        self._ended.set()
        self._publisher.join()      # it must not use the view after it is closed
        self._view.close()
