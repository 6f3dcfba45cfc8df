"""A base that moves in all directions, like libgazebo_ros_planar_move moves it."""
import math
from typing import Tuple

from img_recog import rotations
from img_recog.simulation.physics.body import velocity_at
from img_recog.simulation.physics.drive import Drive, Velocity
from img_recog.simulation.physics.robot import Motors, RobotBody
from img_recog.simulation.simulation_settings import DriveSettings


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
