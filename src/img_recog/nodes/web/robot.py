"""A robot that the page shows and drives."""
import threading
import time
from typing import Any, Callable, Dict, List, Set, Tuple

import cv2
import numpy as np
import rosgraph
import rospy
import yaml

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.nodes.web.driving import Driving
from img_recog.nodes.web.measurements import Measurements, RobotTopics, Topics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.simulation import PosePublisher
from img_recog.nodes.web.tuning import Tuning, color_names_in
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC
from img_recog.recognition.proposal import propose_bounds
from img_recog.recognition.settings import DEFAULT_COLORS, color_names
from img_recog.ros.throttle import ThrottledWarning
from img_recog.settings import SettingError
from img_recog.teleoperation.settings import VelocityLimits

_saving = threading.Lock()      # of all robots: a name is free until its file is there
_FOLDER_ADVICE = 'start it in a folder where files can be written'
_ANSWER_TIMEOUT_S, _POLL_S = 10.0, 0.05


def resolve(robot: str, name: str) -> str:
    """Return the full name of a topic or node of a robot."""
    is_relative = robot and not name.startswith('/')
    return rospy.resolve_name('{}/{}'.format(robot, name) if is_relative else name)


class Robot:
    """The parts of a robot; `page.Robot` and `feed.Robot`.

    name: its namespace, below that of the node; '' for the only robot.
    """

    def __init__(self, name: str, limits: VelocityLimits, pictures: PictureTopics,
                 system: Topics, watched: List[Measurements]):
        """Advertise its topics; pictures and system: those of all robots."""
        self.name = name
        self._pictures = pictures
        self._warn = ThrottledWarning()
        self._watching: Set[object] = set()
        topics = RobotTopics(self.resolve)
        self.measurements = Measurements(system, topics, watched)
        self.driving = Driving(limits, self.resolve('cmd_vel'))
        self.colors = Tuning(self.resolve('color_extract'))
        self._pose = PosePublisher(self.name, lambda: topics.frame_id)

    def resolve(self, name: str) -> str:
        """Return the full name of a topic or node of this robot."""
        return resolve(self.name, name)

    def picture_topics(self) -> List[Tuple[str, str, str]]:
        """Return topic, key of its title and color of each picture."""
        published: Set[str] = set()
        names, topics = list(DEFAULT_COLORS), {}
        try:
            published = {name for name, _ in rospy.get_published_topics()}
            given = rospy.get_param(self.resolve('color_extract'), {})
            names = list(color_names(given.get(COLORS, names)))
            topics = {name: given.get(IMAGE_TOPIC.format(name)) for name in names}
        except (OSError, rospy.ROSException, rosgraph.MasterException, AttributeError,
                SettingError) as error:
            self._warn('the colors of color_extract: %s', one_line(error))
        found = [(self.resolve('usb_cam/image_raw'), 'camera', '')]
        for name in names:
            found.append((self.resolve(topics.get(name) or name + '_image'), 'mask', name))
        found.append((rospy.resolve_name('gazebo/view/image_raw'), 'view', ''))
        camera = self.resolve('camera/rgb/image_raw')
        return found + ([(camera, 'robot_camera', '')] if camera in published else [])

    def watch(self, page: object, is_watched: bool) -> None:
        """Begin or end to follow the parameters for a page."""
        (self._watching.add if is_watched else self._watching.discard)(page)
        self.colors.watch(bool(self._watching))

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Move the robot; raise UserError for a pose that is not allowed."""
        self._pose.publish(x, y, yaw)

    def propose(self, topic: str, x: float, y: float, color: str) -> Dict[str, int]:
        """Set bounds of a color around that in a picture; return them.

        Waits for both for a moment: a page that has just opened a tab shows the last picture, but
        its topic and the parameters may not be followed again yet.
        """
        picture = _wait(lambda: self._pictures.latest(topic))
        if picture is None:
            raise UserError('there is no picture of {}'.format(topic[:100]),
                            'click again when there is one')
        if not _wait(lambda: color in color_names_in(self.colors.values())):
            raise UserError('{} does not answer'.format(self.resolve('color_extract')), 'start it')
        image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
        bounds = propose_bounds(image, x, y)
        self.colors.change(**{'{}_{}'.format(color, part): value
                              for part, value in bounds.items()})
        return bounds

    def save_colors(self) -> str:
        """Save the parameters of the colors with the last changes; return the path."""
        is_settled = _wait(self.colors.is_settled)
        values = self.colors.values()
        names = color_names_in(values)
        if not names or not is_settled:
            raise UserError('{} does not answer'.format(self.resolve('color_extract')), 'start it')
        text = yaml.safe_dump({COLORS: names, **values}, sort_keys=False)
        with _saving:
            path = files.free_output_path('colors', '.yaml')
            with files.atomic_write([path], _FOLDER_ADVICE) as (file,):
                file.write(text.encode())
        return path


def _wait(condition: Callable[[], Any]) -> Any:
    """Return the first true value of a condition, or its last value after a time limit."""
    end_s = time.monotonic() + _ANSWER_TIMEOUT_S
    value = condition()
    while not value and time.monotonic() < end_s:
        time.sleep(_POLL_S)
        value = condition()
    return value
