"""The image topic of the simulation."""
import dataclasses
import time

from std_msgs.msg import Header

from img_recog.conversions import robot_msgs
from img_recog.nodes.gazebo.drawing import Drawing, Job
from img_recog.rendering.camera import Camera
from img_recog.rendering.process import Drawn, Shot
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.simulation.pictures import view
from img_recog.simulation.pictures.view import Viewpoint
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.settings import ViewSettings
from img_recog.simulation.simulator import Simulator

_FRAME = 'view'                 # not a frame of tf: the camera is not part of the robot
_NEAR_M, _FAR_M = 0.05, 60.0


def camera_of(settings: ViewSettings) -> Camera:
    """Return the camera of the images."""
    return Camera(settings.view_width, settings.view_height,
                  view.horizontal_fov(settings.view_width, settings.view_height), _NEAR_M, _FAR_M)


class ViewTopic:
    """Publishes ~view/image_raw (sensor_msgs/Image, rgb8) while it has a subscriber.

    At most one image in each period of wall time. While images of a camera are drawn, it is drawn
    with the next one: the simulation does not wait for it.
    """

    def __init__(self, settings: ViewSettings, drawing: Drawing, number: int, above: Viewpoint):
        """Advertise the topic; number: of its camera in `drawing`; above: of the view `above`."""
        self._settings, self._drawing, self._number = settings, drawing, number
        self._above = above
        self._images = ImagePublisher('~view/image_raw')
        self._next_s = 0.0

    def configure(self, view: str) -> None:
        """Show the simulation from another viewpoint, one of VIEWS, from now on."""
        self._settings = dataclasses.replace(self._settings, view=view)
        self._next_s = 0.0

    def update(self, simulator: Simulator, parts: Parts) -> None:
        """Request an image if there is a subscriber and it is time; to be called by the loop."""
        if not self._images.get_num_connections():
            return
        self._drawing.start()
        now_s = time.monotonic()
        if now_s < self._next_s or not self._drawing.is_ready:
            return
        self._next_s = now_s + 1 / self._settings.view_rate
        self._drawing.add_to_next(lambda time_s: self._job(simulator, time_s))
        if not self._drawing.is_busy:
            self._drawing.submit([], parts.poses(), simulator.time_s)

    def _job(self, simulator: Simulator, time_s: float) -> Job:
        viewpoint = self._above
        if self._settings.view == 'follow' and simulator.vehicles:
            viewpoint = view.follow(simulator.vehicles[0].robot.pose())
        return Job(Shot(self._number, viewpoint.pose()),
                   lambda drawn: self._publish(drawn, time_s))

    def _publish(self, drawn: Drawn, time_s: float) -> None:
        header = Header(stamp=robot_msgs.stamp_of(time_s), frame_id=_FRAME)
        self._images.publish(drawn.image, 'rgb8', header)
