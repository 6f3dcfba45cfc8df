"""A robot with its drive and its sensors."""
import dataclasses
from typing import Tuple, cast

from img_recog import rotations
from img_recog.simulation.carrier import Carrier
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.robot import SimulatedRobot
from img_recog.simulation.physics.world import World
from img_recog.simulation.robot_spec import RobotSpec
from img_recog.simulation.sensors.odometry import WORLD, OdometrySettings
from img_recog.simulation.simulation_settings import SpawnSettings, whole_steps


class Vehicle(Carrier):
    """Drives one robot and reads its sensors; the simulator advances the physics.

    drive: what moves it; odometry: the settings of that, the defaults for a robot without one;
    lift: how far it was moved upward, onto what it was in, when it was last put somewhere.
    """

    def __init__(self, spec: RobotSpec, world: World):
        """Load the robot into a world.

        Raises SimulationError when a setting does not fit the robot or the physics; nothing is
        left in the world then.
        """
        settings = spec.settings
        self.drive = spec.new_drive()
        robot = SimulatedRobot(spec.model, self.drive.motors, settings.spawn,
                               world.physics_client_id)
        super().__init__(spec, world, robot, self.drive)
        self.robot: SimulatedRobot = robot
        self.odometry = cast(OdometrySettings,
                             self.settings.sensors.get('odometry') or OdometrySettings())
        self._lift()
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s,
                                        world.step_s)

    def _lift(self) -> None:
        self.lift = self._world.lift(self.robot)

    def command(self, linear_x: float, angular_z: float, linear_y: float = 0.0) -> None:
        """Drive at linear_x m/s and angular_z rad/s until the next command.

        linear_y: to the left in m/s, for a drive that can.
        """
        self.drive.command(linear_x, angular_z, linear_y)

    @property
    def odometry_origin(self) -> Tuple[float, float, float]:
        """Where the odometry is zero: x, y in m and yaw in rad, in the world."""
        if self.odometry.odometry_source == WORLD:
            return 0.0, 0.0, 0.0
        spawn = self.settings.spawn
        return spawn.x_pos, spawn.y_pos, spawn.yaw

    def _act(self) -> None:
        self.drive.update(self.robot)

    def reset(self) -> None:
        """Move the robot back to its start, at rest and without a command."""
        self.drive.reset()
        self.robot.reset()
        self._lift()
        super().reset()

    def set_start(self, spawn: SpawnSettings) -> None:
        """Start from another pose, also after a reset; moves the robot there."""
        self.settings = dataclasses.replace(self.settings, spawn=spawn)
        self.robot.spawn = spawn
        self.reset()

    def move_to(self, x: float, y: float, yaw: float) -> None:
        """Move the robot to x, y in m and yaw in rad, at rest and without a command.

        It is put at z_pos, as at the start.
        """
        self.drive.reset()
        self.robot.place(BodyPose((x, y, self.settings.spawn.z_pos),
                                  rotations.of_yaw(yaw), self.robot.pose().joints))
        self.robot.stop_wheels()
        self.notify_teleported()

    def notify_teleported(self) -> None:
        """Call after the robot was moved from outside; it is lifted onto what it is in."""
        self._lift()
        self.drive.notify_stopped()
        super().notify_teleported()
