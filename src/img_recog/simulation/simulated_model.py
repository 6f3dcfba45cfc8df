"""Models with sensors, and robots: models with a drive."""
import dataclasses
from typing import Dict, List, Sequence, Set, Tuple, cast

from img_recog import rotations
from img_recog.model import Tree
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.mounted_sensors import MountedSensors
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.model_bodies import ModelBodies
from img_recog.simulation.physics.robot import RobotBody
from img_recog.simulation.physics.world import World
from img_recog.simulation.sensors.odometry import WORLD, OdometrySettings
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.sensors.sensor import ScheduledSensor
from img_recog.simulation.simulation_settings import SpawnSettings, whole_steps


class SimulatedModel(ModelBodies):
    """A model of the world with its sensors.

    Attributes:
        sensors: Sensors of each body that has some.
    """

    def __init__(self, name: str, trees: Sequence[Tree], bodies: Sequence[FramedBody]):
        super().__init__(name, trees, bodies)
        self.sensors: List[MountedSensors] = []

    @property
    def cameras(self) -> Dict[str, RobotCamera]:
        """The cameras by the names of their sensors."""
        return {name: camera for mounted in self.sensors
                for name, camera in mounted.cameras.items()}

    def set_sensor_enabled(self, sensor: str, enabled: bool) -> None:
        """Enable or disable a sensor; see `MountedSensors.set_enabled`."""
        for mounted in self.sensors:
            mounted.set_enabled(sensor, enabled)

    def before_step(self, steps: int) -> None:
        """Do what is due after `steps` steps of the physics, before the next one."""
        for mounted in self.sensors:
            mounted.before_step(steps)

    def next_event(self, steps: int) -> int:
        """Return the first step after `steps` at which something is due."""
        return min(mounted.next_event(steps) for mounted in self.sensors)

    def due(self, steps: int) -> List[Tuple[str, ScheduledSensor]]:
        """Return the sensors that are read after `steps` steps, each with the name of its body."""
        return [(mounted.body.name, scheduled) for mounted in self.sensors
                for scheduled in mounted.due(steps)]

    def restart(self) -> None:
        """Let the sensors begin anew, after a reset."""
        for mounted in self.sensors:
            mounted.reset()

    def restart_noise(self) -> None:
        """Let the noise of the sensors begin anew, as when time does."""
        for mounted in self.sensors:
            mounted.restart_noise()

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        for mounted in self.sensors:
            if mounted.body in bodies:
                mounted.notify_teleported()


class Robot(SimulatedModel):
    """A model with a drive. The simulator advances the physics.

    Attributes:
        body: Body of the robot.
        drive: Drive, also if the robot has none that is simulated.
        spec: Configuration from which the robot was made.
        settings: Settings of all parts, in which an empty frame is the root link.
        odometry: Settings of the odometry; the defaults for a robot without odometry.
        lift: How far the robot was moved upward, onto what it was in, when it was last placed.
    """

    is_robot = True

    def __init__(self, spec: ConfiguredModel, world: World):
        """Load the robot into PyBullet. `World.add` makes it a part of the world.

        Raises:
            SimulationError: if a setting does not fit the robot or the physics.
        """
        settings = spec.settings
        self.spec, self.drive, self._world = spec, spec.new_drive(), world
        self.body = RobotBody(spec.model, self.drive.motors, settings.spawn,
                              world.physics_client_id)
        super().__init__(self.body.name, [Tree(self.body.name, spec.model)], [self.body])
        mounted = MountedSensors(spec, world, self.body, self.drive)
        self.sensors = [mounted]
        self.settings = mounted.settings
        self.odometry = cast(OdometrySettings,
                             self.settings.sensors.get('odometry') or OdometrySettings())
        self._lift()
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s,
                                        world.step_s)
        self._steps = self._drives_from = 0

    def _lift(self) -> None:
        self.lift = self._world.lift(self.body)

    @property
    def missing_sensors(self) -> Dict[str, str]:
        """The links that the robot does not have, by the names of the sensors left out."""
        return self.sensors[0].missing

    @property
    def sensor_kinds(self) -> Set[str]:
        """The kinds of sensors that the robot has, also of those that are disabled."""
        return self.sensors[0].kinds

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

    def before_step(self, steps: int) -> None:
        super().before_step(steps)
        if (steps - self._drives_from) % self._drive_steps == 0:
            self.drive.update(self.body)

    def next_event(self, steps: int) -> int:
        wait = self._drive_steps - (steps - self._drives_from) % self._drive_steps
        return min(steps + wait, super().next_event(steps))

    def due(self, steps: int) -> List[Tuple[str, ScheduledSensor]]:
        self._steps = steps
        return super().due(steps)

    def reset(self) -> None:
        """Move the robot back to its start, at rest and without a command."""
        self.drive.reset()
        super().reset()
        self._lift()

    def restart(self) -> None:
        super().restart()
        self._drives_from = self._steps

    def restart_noise(self) -> None:
        super().restart_noise()
        self._steps = self._drives_from = 0

    def set_start(self, spawn: SpawnSettings) -> None:
        """Start from another pose, also after a reset; moves the robot there."""
        self.settings = dataclasses.replace(self.settings, spawn=spawn)
        self.body.spawn = spawn
        self.reset()
        self.restart()

    def move_to(self, x: float, y: float, yaw: float) -> None:
        """Move the robot to x, y in m and yaw in rad, at rest and without a command.

        It is put at z_pos, as at the start.
        """
        self.drive.reset()
        self.body.place(BodyPose((x, y, self.settings.spawn.z_pos),
                                 rotations.of_yaw(yaw), self.body.pose().joints))
        self.body.stop_wheels()
        self.notify_moved(self.bodies)

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        """Call after the robot was moved from outside; it is lifted onto what it is in."""
        self._lift()
        self.drive.notify_stopped()
        super().notify_moved(bodies)

    def notify_loaded_again(self) -> None:
        self.drive.notify_stopped()
