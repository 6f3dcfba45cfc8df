"""Odometry: the pose of a robot, from the world or from the turns of its wheels."""
import math

import numpy as np

from img_recog import rotations
from img_recog.simulation.bodies.body import Motion
from img_recog.simulation.bodies.robot import Robot
from img_recog.simulation.sensors.sensor import Sensor
from img_recog.simulation.settings import DriveSettings, OdometrySettings

WORLD = 'world'


class WorldOdometry(Sensor):
    """The true pose of a frame in the world (libgazebo_ros_diff_drive's odometrySource world)."""

    def __init__(self, robot: Robot, frame: str):
        """Measure a link of `robot`; SimulationError when there is no such link."""
        robot.check_frame('base_frame', frame)
        self._robot, self._frame = robot, frame

    def read(self) -> Motion:
        """Return the motion of the frame."""
        return self._robot.motion(self._frame)


class WheelOdometry(Sensor):
    """Integrates the turns of the wheels; the pose is zero at the start and after a reset."""

    def __init__(self, robot: Robot, drive: DriveSettings, period_s: float):
        self._robot, self._period_s = robot, period_s
        self._radius, self._separation = drive.wheel_diameter / 2, drive.wheel_separation
        self.restart()

    def restart(self) -> None:
        """Set the pose to zero."""
        self._x = self._y = self._yaw = 0.0
        self._wheels = self._robot.wheel_positions()

    def read(self) -> Motion:
        """Return the motion of the point between the wheels; to be called once a period."""
        wheels = self._robot.wheel_positions()
        left, right = ((now - before) * self._radius for now, before in zip(wheels, self._wheels))
        self._wheels = wheels
        distance, turn = (left + right) / 2, (right - left) / self._separation
        # a chord has the direction of its arc at the middle (Siegwart et al. 2011, 5.2.4)
        self._x += distance * math.cos(self._yaw + turn / 2)
        self._y += distance * math.sin(self._yaw + turn / 2)
        self._yaw += turn
        return Motion(np.array([self._x, self._y, 0.0]),
                      rotations.of_yaw(self._yaw),
                      np.array([distance / self._period_s, 0.0, 0.0]),
                      np.array([0.0, 0.0, turn / self._period_s]))


def make_odometry(robot: Robot, settings: OdometrySettings, drive: DriveSettings,
                  period_s: float) -> Sensor:
    """Return the odometry for `settings`; SimulationError when base_frame is not a link."""
    if settings.odometry_source == WORLD:
        return WorldOdometry(robot, settings.base_frame or robot.root)
    return WheelOdometry(robot, drive, period_s)
