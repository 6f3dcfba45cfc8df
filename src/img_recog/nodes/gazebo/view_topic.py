"""The image topic of the simulation."""
import dataclasses
import math
import time

from std_msgs.msg import Header

from img_recog.conversions import robot_msgs
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Picture, Shot
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.simulation.pictures import view
from img_recog.simulation.pictures.view import Viewpoint
from img_recog.simulation.simulation_settings import ViewSettings
from img_recog.simulation.simulator import Simulator

_FRAME = 'view'                 # not a frame of tf: the camera is not part of the robot


class ViewTopic:
    """Publishes ~view/image_raw (sensor_msgs/Image, rgb8) while it has a subscriber."""

    def __init__(self, settings: ViewSettings, above: Viewpoint):
        """Advertise the topic; above: the viewpoint of the view `above`."""
        self._settings, self._above = settings, above
        width, height = settings.view_width, settings.view_height
        self.camera = Camera(width, height, view.horizontal_fov(width, height))
        self._images = ImagePublisher('~view/image_raw')
        self._next_s = 0.0

    def configure(self, view: str) -> None:
        """Show the simulation from another viewpoint, one of VIEWS, from now on."""
        self._settings = dataclasses.replace(self._settings, view=view)
        self._next_s = 0.0

    def is_wanted(self) -> bool:
        """Return whether the topic has a subscriber."""
        return self._images.get_num_connections() > 0

    def take_due(self) -> bool:
        """Return whether it is time for an image: once in each period of wall time."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return False
        self._next_s = now_s + 1 / self._settings.view_rate
        return True

    def shot(self, simulator: Simulator) -> Shot:
        """Return what is to be drawn now."""
        viewpoint = self._above
        if self._settings.view == 'follow' and simulator.robots:
            viewpoint = view.follow(simulator.robots[0].body.pose())
        pose = viewpoint.pose()
        edges = self.camera.edges
        near, far = view.near_and_far(pose, (edges.right, edges.top))
        roof = view.ceiling(simulator.world, [each.body for each in simulator.robots])
        return Shot(self.camera._replace(near=near, far=far), pose,
                    ceiling=roof if roof < pose[2, 3] else math.inf)

    def publish(self, picture: Picture, time_s: float) -> None:
        """Publish what was drawn at a simulated time."""
        header = Header(stamp=robot_msgs.stamp_of(time_s), frame_id=_FRAME)
        self._images.publish(picture[0], 'rgb8', header)
