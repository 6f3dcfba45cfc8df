"""A bumper: what touches the shapes of a link."""
from dataclasses import dataclass
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
import pybullet

from img_recog.formats.gazebo_tags import NAME, RATE, TOPIC, Row, Tags
from img_recog.settings import Settings, above, any_value, not_empty, setting
from img_recog.simulation.physics.tires import owner
from img_recog.simulation.sensors.sensor import Mount, Sensor

# of libgazebo_ros_bumper of gazebo_plugins, with its default topic
TAGS = Tags(('gazebo_ros_bumper',), (
    Row('contact_period_s', RATE, 'sensor', 'update_rate'),
    Row('contact_frame', NAME, 'plugin', 'frameName'),
    Row('contact_topic', TOPIC, 'plugin', 'bumperTopicName')),
    sensors=('contact',), frame='contact_frame', needs_sensor=True)


@dataclass(frozen=True)
class ContactSettings(Settings):
    """contact_frame: of the messages. contact_period_s: a multiple of the physics step."""

    contact_frame: str = setting('', any_value())
    contact_period_s: float = setting(0.02, above(0))
    contact_topic: str = setting('bumper_states', not_empty())


class Touch(NamedTuple):
    """What one part of another body does to the link; all in the world.

    own, other: parts, as MODEL::LINK. positions, normals (toward the link), forces (on the link):
    of shape (points, 3), in m and N; depths (points,): m. origin (3,): of the sensor.
    """

    own: str
    other: str
    positions: np.ndarray
    normals: np.ndarray
    depths: np.ndarray
    forces: np.ndarray
    origin: np.ndarray


class ContactSensor(Sensor):
    """Measures what touches a link of the robot in the last step of the physics."""

    def __init__(self, mount: Mount, settings: ContactSettings):
        """Mount the sensor; SimulationError when the robot has no link for it."""
        self._robot, self._frame = mount.robot, mount.frame('contact_frame',
                                                            settings.contact_frame)
        self._surfaces = mount.robot.surfaces(mount.link)

    def read(self) -> List[Touch]:
        """Return what touches the link now, one for each part of another body."""
        client = self._robot.physics_client_id
        found: Dict[Tuple[int, int, int], List[tuple]] = {}
        for link in self._surfaces:
            # the arguments are named: PyBullet ignores a linkIndexA without bodyA
            for point in pybullet.getContactPoints(bodyA=self._robot.body_id, linkIndexA=link,
                                                   physicsClientId=client) or ():
                if point[9] > 0 or point[8] <= 0:       # a force, or no gap
                    found.setdefault((link, point[2], point[4]), []).append(point)
        origin = self._robot.motion(self._frame).position if found else np.zeros(3)
        return [self._touch(part, points, origin) for part, points in found.items()]

    def _touch(self, part: Tuple[int, int, int], points: Sequence[tuple],
               origin: np.ndarray) -> Touch:
        own, body, link = part
        normals = np.array([point[7] for point in points])
        forces = np.array([force_of(point) for point in points])
        return Touch('{}::{}'.format(self._robot.name, self._surfaces[own]),
                     _name_of(body, link, self._robot.physics_client_id),
                     np.array([point[5] for point in points]), normals,
                     np.array([max(0.0, -point[8]) for point in points]), forces, origin)


def force_of(point: tuple) -> np.ndarray:
    """Return the force (3,) on the first body of a contact."""
    normal, first, second = (np.array(point[index]) for index in (7, 11, 13))
    # Where PyBullet has the bodies in the other order, it turns the normal only. By that, the
    # directions of friction are right-handed or left-handed.
    own = np.sign(np.cross(first, second) @ normal)
    return point[9] * normal + own * (point[10] * first + point[12] * second)


def _name_of(body: int, link: int, client: int) -> str:
    root, model = pybullet.getBodyInfo(body, physicsClientId=client)
    name = root if link == -1 else pybullet.getJointInfo(body, link, physicsClientId=client)[12]
    return '{}::{}'.format(model.decode(), owner(name.decode()))
