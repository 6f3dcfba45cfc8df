"""What all drives of a robot have in common: the command that holds, its limits and its end."""
import math
from typing import NamedTuple, Tuple

from img_recog.errors import SimulationError
from img_recog.settings import computable
from img_recog.simulation.physics.robot import Motors, RobotBody
from img_recog.simulation.simulation_settings import DriveSettings

_ROUNDING_PERIODS = 1e-6        # 0.07 s divided by 0.01 s is a little more than 7


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
        linear = _Range.of(settings.max_linear_velocity, settings.min_linear_velocity)
        angular = _Range.of(settings.max_angular_velocity, settings.min_angular_velocity)
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
        self._command = _limited(Velocity(*map(computable, given)), self._velocities)
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


class _Range(NamedTuple):
    """The lowest and the highest value of a velocity or an acceleration."""

    low: float
    high: float

    @staticmethod
    def of(maximum: float, minimum: float) -> '_Range':
        """Return that of two settings, of which 0 means that it is not given."""
        high = maximum or math.inf
        return _Range(minimum or -high, high)


def _limited(values: Velocity, ranges: Tuple[_Range, _Range, _Range]) -> Velocity:
    return Velocity(*(max(limit.low, min(limit.high, value))
                      for value, limit in zip(values, ranges)))
