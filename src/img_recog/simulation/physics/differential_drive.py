"""Wheels on both sides, driven like libgazebo_ros_diff_drive and diff_drive_controller do."""
from typing import Sequence, Tuple

from img_recog.errors import SimulationError
from img_recog.simulation.physics.drive import Drive, Velocity
from img_recog.simulation.physics.robot import Motors, RobotBody
from img_recog.simulation.simulation_settings import DriveSettings

# m/s at the rim: once one side is this near to its target, the ramp of both ends (gazebo_plugins)
_RAMP_END_TOLERANCE = 0.01

_Sides = Tuple[float, float]


class DifferentialDrive(Drive):
    """One or more wheels on each side, those of a side at the same speed.

    Where several wheels are in line, they slip when the robot turns: then it turns less than
    commanded, and than its encoders count. The speeds at the rims change no faster than
    `wheel_acceleration`.
    """

    def __init__(self, settings: DriveSettings):
        """Raise SimulationError when the joints are not those of wheels on two sides."""
        left, right = settings.left_joints, settings.right_joints
        if set(left) == set(right):
            raise SimulationError('left_joint: got {!r}, the same as right_joint; a differential '
                                  'drive has two wheels'.format(settings.left_joint))
        if len({*left, *right}) < len(left) + len(right) or not left or not right:
            raise SimulationError('left_joint: got {!r}, and right_joint {!r}, expected joints of '
                                  'wheels on two sides, each once'.format(
                                      settings.left_joint, settings.right_joint))
        self._counts = len(left), len(right)
        self._separation = settings.wheel_separation * settings.wheel_separation_multiplier
        radius = settings.wheel_diameter / 2
        self._radii = (radius * settings.left_wheel_radius_multiplier,
                       radius * settings.right_wheel_radius_multiplier)
        self._max_change = settings.wheel_acceleration * settings.drive_period_s
        super().__init__(settings, Motors(
            (*(('left_joint', name) for name in left), *(('right_joint', name) for name in right)),
            settings.wheel_torque))

    def reset(self) -> None:
        """Forget the last command and stand."""
        self._ramp: _Sides = (0.0, 0.0)
        super().reset()

    def notify_stopped(self) -> None:
        """Set the motors again at the next update."""
        self._set: Sequence[float] = ()

    def move(self, robot: RobotBody, velocity: Velocity) -> None:
        """Set the target velocities of the wheels."""
        difference = velocity.turn * self._separation / 2
        target = velocity.forward - difference, velocity.forward + difference
        speeds = self._towards(target, robot)
        if speeds != self._set:
            self._set = speeds
            (left, right), (left_radius, right_radius) = speeds, self._radii
            robot.set_wheel_velocities((left / left_radius,) * self._counts[0]
                                       + (right / right_radius,) * self._counts[1])

    def _towards(self, target: _Sides, robot: RobotBody) -> _Sides:
        """Return what the motors are set to for a target.

        The ramp is that of gazebo_plugins: what the wheels lack now is added to what it was last.
        So where they slip it goes beyond the target, and there the next one begins.
        """
        if self._max_change == 0:
            return target
        now = self._rims(robot.wheel_velocities())
        if any(abs(wanted - speed) < _RAMP_END_TOLERANCE for wanted, speed in zip(target, now)):
            return target
        left, right = (before + max(-self._max_change, min(self._max_change, wanted - speed))
                       for before, wanted, speed in zip(self._ramp, target, now))
        self._ramp = left, right
        return self._ramp

    def _rims(self, wheels: Sequence[float]) -> _Sides:
        """Return the mean of each side at the rims, in m or m/s, of values in rad or rad/s."""
        left, right = self._counts
        return (sum(wheels[:left]) / left * self._radii[0],
                sum(wheels[left:]) / right * self._radii[1])

    def encoders(self, robot: RobotBody) -> _Sides:
        """Return how far the rims of the left and right wheels have turned, in m."""
        return self._rims(robot.wheel_positions())

    def travelled(self, before: Tuple[float, ...], now: Tuple[float, ...]) -> Velocity:
        """Return the way of a robot whose wheels do not slip."""
        left, right = now[0] - before[0], now[1] - before[1]
        return Velocity((left + right) / 2, 0.0, (right - left) / self._separation)
