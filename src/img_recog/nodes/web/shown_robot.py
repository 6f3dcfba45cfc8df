"""A robot that pages show and drive."""
from typing import List, NamedTuple

import rospy

from img_recog.errors import UserError, one_line
from img_recog.nodes.web.color_samples import ColorSamples
from img_recog.nodes.web.color_tuning import ColorTuning
from img_recog.nodes.web.driving import Driving
from img_recog.nodes.web.measurements import RobotMeasurements, WatchedTopics
from img_recog.nodes.web.navigation_topics import NavigationTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.simulation_service import PosePublisher
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC
from img_recog.recognition.recognition_settings import DEFAULT_COLORS, color_names
from img_recog.ros import parameters, timed_xmlrpc
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.teleoperation.teleop_settings import VelocityLimits


def resolve(robot: str, name: str) -> str:
    """Return the full name of a topic or node of a robot."""
    is_relative = robot and not name.startswith('/')
    return rospy.resolve_name('{}/{}'.format(robot, name) if is_relative else name)


class PictureTopic(NamedTuple):
    """A topic with images; title: the key of its title, which may have a color in it."""

    topic: str
    title: str
    color: str = ''


class ShownRobot:
    """A robot that pages show and drive.

    name: its namespace, below that of the node; '' for the only robot. topics: what is measured,
    of the system and of the robot. navigation: the last of them.
    """

    def __init__(self, name: str, limits: VelocityLimits, pictures: PictureTopics,
                 system: WatchedTopics):
        """Advertise its topics; pictures and system: those of all robots."""
        self.name = name
        self._warn = ThrottledWarning()
        own = RobotMeasurements(self.resolve)
        self.navigation = NavigationTopics(self.resolve, lambda: own.frame_id)
        self.topics = system, own, self.navigation
        self.driving = Driving(limits, self.resolve('cmd_vel'))
        self.colors = ColorTuning(self.resolve('color_extract'))
        self.samples = ColorSamples(self.resolve('usb_cam/image_raw'), pictures)
        self.pose = PosePublisher(self.name, lambda: own.frame_id)

    def resolve(self, name: str) -> str:
        """Return the full name of a topic or node of this robot."""
        return resolve(self.name, name)

    def picture_topics(self) -> List[PictureTopic]:
        """Return the pictures that there can be, those of the colors last. Waits for the master.

        page.css makes those after the third smaller if they are many.
        """
        names, topics = list(DEFAULT_COLORS), {}
        try:
            given = parameters.value(self.resolve('color_extract')) or {}
            names = list(color_names(given.get(COLORS, names)))
            topics = {name: given.get(IMAGE_TOPIC.format(name)) for name in names}
        except (*timed_xmlrpc.ERRORS, UserError, AttributeError) as error:
            self._warn('the colors of color_extract: %s', one_line(error))
        return [
            PictureTopic(self.resolve('usb_cam/image_raw'), 'camera'),
            PictureTopic(rospy.resolve_name('gazebo/view/image_raw'), 'view'),
            PictureTopic(self.resolve('camera/rgb/image_raw'), 'robot_camera'),
            *(PictureTopic(self.resolve(topics.get(name) or name + '_image'), 'mask', name)
              for name in names)]
