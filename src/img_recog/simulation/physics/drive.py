"""The drives of a robot: what its command does to its wheels or to its base."""
import math
from typing import NamedTuple, Sequence, Tuple

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.settings import LARGEST
from img_recog.simulation.physics.body import velocity_at
from img_recog.simulation.physics.robot import Motors, RobotBody
from img_recog.simulation.simulation_settings import DriveSettings

_ROUNDING_PERIODS = 1e-6        # 0.07 s divided by 0.01 s is a little more than 7
# m/s at the rim: once one side is this near to its target, the ramp of both ends (gazebo_plugins)
_RAMP_END_TOLERANCE = 0.01

_Sides = Tuple[float, float]


class Velocity(NamedTuple):
    """Of the root link: forward and to the left in m/s, and to the left about z in rad/s.

    Of a way, these are m and rad.
    """

    forward: float
    left: float
    turn: float


STAND = Velocity(0.0, 0.0, 0.0)


class Drive:
    """Turns commands into what moves a robot, once a drive period.

    This class itself moves nothing: it is the drive of a robot that does not drive.

    motors: the joints that it drives. timed_out: whether `cmd_vel_timeout` has ended the last
    command, which was not a stop.
    """

    def __init__(self, settings: DriveSettings, motors: Motors = Motors((), 0.0)):
        self.motors = motors
        self._period_s = settings.drive_period_s
        linear = _Range.of(settings.max_linear_velocity, settings.min_linear_velocity, LARGEST)
        angular = _Range.of(settings.max_angular_velocity, settings.min_angular_velocity, LARGEST)
        self._velocities = linear, linear, angular
        linear = _Range.of(settings.max_linear_acceleration, settings.min_linear_acceleration)
        angular = _Range.of(settings.max_angular_acceleration, settings.min_angular_acceleration)
        self._accelerations = linear, linear, angular
        # in periods: counting is exact, adding up seconds is not
        self._timeout = self._given_timeout = settings.cmd_vel_timeout / settings.drive_period_s
        self.reset()

    @property
    def timeout_s(self) -> float:
        """After which time without a command it stops; 0 for never."""
        return self._timeout * self._period_s

    def scale_timeout(self, factor: float) -> None:
        """Make `cmd_vel_timeout` this many times as long as it is in the settings."""
        self._timeout = factor * self._given_timeout

    def reset(self) -> None:
        """Forget the last command and stand."""
        self._command = self._velocity = STAND
        self._age = 0
        self.timed_out = False
        self.notify_stopped()

    def notify_stopped(self) -> None:
        """Call after something else has stopped or moved the robot."""

    def command(self, linear_x: float, angular_z: float, linear_y: float = 0.0) -> None:
        """Set the velocity of the root link that holds until the next command: m/s and rad/s.

        Raises SimulationError if a number is not finite.
        """
        given = Velocity(linear_x, linear_y, angular_z)
        if not all(map(math.isfinite, given)):
            raise SimulationError('command: got {}, expected finite numbers'.format([*given]))
        self._command = _limited(given, self._velocities)
        self._age = 0
        self.timed_out = False

    def update(self, robot: RobotBody) -> None:
        """Move the robot by the command; to be called once a drive period."""
        if self._timeout and self._age > self._timeout - _ROUNDING_PERIODS:
            self.timed_out = self.timed_out or self._command != STAND
            self._command = STAND
        self._age += 1
        if self._velocity != self._command:
            self._velocity = self._next(self._velocity)
        self.move(robot, self._velocity)

    def _next(self, before: Velocity) -> Velocity:
        """Return the velocity one period after another one, on the way to the command."""
        change = Velocity(*((wanted - now) / self._period_s
                            for wanted, now in zip(self._command, before)))
        allowed = _limited(change, self._accelerations)
        # where nothing is limited, exactly the command
        return Velocity(*(wanted if kept == given else now + kept * self._period_s
                          for wanted, now, given, kept in zip(self._command, before, change,
                                                              allowed)))

    def move(self, robot: RobotBody, velocity: Velocity) -> None:
        """Move the robot for a drive period."""

    def encoders(self, robot: RobotBody) -> Tuple[float, ...]:
        """Return what the drive counts of the way; `travelled` compares two of them."""
        return ()

    def travelled(self, before: Tuple[float, ...], now: Tuple[float, ...]) -> Velocity:
        """Return the way between two readings: m forward, m to the left, and rad to the left."""
        return STAND


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


class PlanarDrive(Drive):
    """Gives the base its velocity; what its wheels do does not matter.

    So mecanum and omni wheels need not be modeled. The robot slides on the floor without friction.
    """

    def __init__(self, settings: DriveSettings):
        super().__init__(settings, Motors((), 0.0, slides=True))

    def move(self, robot: RobotBody, velocity: Velocity) -> None:
        """Set the velocity in the plane and about z; it can fall, and tilt on a slope."""
        frame, point, linear, angular = robot.frame_state(robot.root)
        forward, left, turn = velocity
        # as it is in the middle of the period
        yaw = rotations.yaw(frame[1]) + turn * self._period_s / 2
        vertical = velocity_at(frame[0], point, linear, angular)[2]
        robot.set_velocity((forward * math.cos(yaw) - left * math.sin(yaw),
                            forward * math.sin(yaw) + left * math.cos(yaw), vertical),
                           (angular[0], angular[1], turn))

    def encoders(self, robot: RobotBody) -> Tuple[float, ...]:
        """Return where the root link is: x and y in m, and yaw in rad, in the world."""
        (x, y, _), orientation = robot.frame_state(robot.root).frame
        return x, y, rotations.yaw(orientation)

    def travelled(self, before: Tuple[float, ...], now: Tuple[float, ...]) -> Velocity:
        """Return the true way."""
        x, y = now[0] - before[0], now[1] - before[1]
        turn = math.remainder(now[2] - before[2], 2 * math.pi)
        yaw = before[2] + turn / 2
        return Velocity(x * math.cos(yaw) + y * math.sin(yaw),
                        y * math.cos(yaw) - x * math.sin(yaw), turn)


class _Range(NamedTuple):
    """The lowest and the highest value of a velocity or an acceleration."""

    low: float
    high: float

    @staticmethod
    def of(maximum: float, minimum: float, otherwise: float = math.inf) -> '_Range':
        """Return that of two settings, of which 0 means that it is not given."""
        high = maximum or otherwise
        return _Range(minimum or -high, high)


def _limited(values: Velocity, ranges: Tuple[_Range, _Range, _Range]) -> Velocity:
    return Velocity(*(max(limit.low, min(limit.high, value))
                      for value, limit in zip(values, ranges)))
