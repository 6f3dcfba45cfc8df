"""Odometry: the pose of a robot, from the world or from the encoders of its drive."""
import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from img_recog import rotations
from img_recog.formats.gazebo_tags import Tags
from img_recog.settings import Settings, above, any_value, not_empty, one_of, setting
from img_recog.simulation.physics.body import Motion
from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.physics.robot import RobotBody
from img_recog.simulation.sensors.sensor import Mount, Sensor

WORLD, ENCODER = 'world', 'encoder'

TAGS = Tags((), ())         # a drive has them


@dataclass(frozen=True)
class OdometrySettings(Settings):
    """Odometry like that of libgazebo_ros_diff_drive.

    odometry_source: world is the true pose in the world, encoder is added up from the start by
    what the drive counts. odom_frame, base_frame: frame_id and child_frame_id; an empty
    base_frame is the root link, and one that is no link is a name for that. publish_odom_tf:
    whether the pose is published on tf as well. odometry_period_s: a multiple of the physics
    step, in simulated s.
    """

    odometry_source: str = setting(WORLD, one_of(ENCODER, WORLD))
    odom_frame: str = setting('odom', not_empty())
    base_frame: str = setting('', any_value())
    publish_odom_tf: bool = setting(True)
    odometry_period_s: float = setting(0.01, above(0))
    odometry_topic: str = setting('odom', not_empty())


class WorldOdometry(Sensor):
    """The true pose of a frame in the world (libgazebo_ros_diff_drive's odometrySource world)."""

    def __init__(self, mount: Mount, settings: OdometrySettings):
        self._robot = mount.robot
        self._frame = settings.base_frame if mount.robot.has_frame(settings.base_frame) else None

    def read(self) -> Motion:
        """Return the motion of the frame."""
        return self._robot.motion(self._frame)


class EncoderOdometry(Sensor):
    """Adds up the way that the drive counts; the pose is zero at the start and after a reset.

    It misses that wheels slip.
    """

    def __init__(self, mount: Mount, settings: OdometrySettings):
        self._robot = cast(RobotBody, mount.robot)
        self._drive = cast(Drive, mount.drive)
        self._period_s = settings.odometry_period_s
        self.restart()

    def restart(self) -> None:
        """Set the pose to zero."""
        self._x = self._y = self._yaw = 0.0
        self.notify_teleported()

    def notify_teleported(self) -> None:
        """Count on from where the robot is now."""
        self._encoders = self._drive.encoders(self._robot)

    def read(self) -> Motion:
        """Return the motion of the point between the wheels; to be called once a period."""
        before, self._encoders = self._encoders, self._drive.encoders(self._robot)
        forward, left, turn = self._drive.travelled(before, self._encoders)
        # a chord has the direction of its arc at the middle (Siegwart et al. 2011, 5.2.4)
        cos, sin = math.cos(self._yaw + turn / 2), math.sin(self._yaw + turn / 2)
        self._x += forward * cos - left * sin
        self._y += forward * sin + left * cos
        self._yaw += turn
        return Motion(np.array([self._x, self._y, 0.0]),
                      rotations.of_yaw(self._yaw),
                      np.array([forward / self._period_s, left / self._period_s, 0.0]),
                      np.array([0.0, 0.0, turn / self._period_s]))


def make_odometry(mount: Mount, settings: OdometrySettings) -> Sensor:
    """Return the odometry for `settings`."""
    is_world = settings.odometry_source == WORLD
    return (WorldOdometry if is_world else EncoderOdometry)(mount, settings)
