"""A robot with its drive and its sensors."""
import dataclasses
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from img_recog import rotations
from img_recog.simulation.bodies.body import Pose
from img_recog.simulation.bodies.differential_drive import DifferentialDrive
from img_recog.simulation.bodies.robot import JointStates, Robot
from img_recog.simulation.bodies.world import World
from img_recog.simulation.descriptions.description import Description
from img_recog.simulation.sensors.imu import Imu
from img_recog.simulation.sensors.laser_scanner import LaserScanner
from img_recog.simulation.sensors.odometry import WORLD, make_odometry
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.sensors.sensor import ScheduledSensor, Sensor
from img_recog.simulation.settings import (CameraSettings, ImuSettings, RobotSettings,
                                           ScanSettings, SpawnSettings, nearest_period,
                                           whole_steps)


class Reading(NamedTuple):
    """What a sensor measured.

    robot, sensor: their names; time_s: simulated time; value: of the type that the sensor's `read`
    returns.
    """

    robot: str
    sensor: str
    time_s: float
    value: Any


class _JointStateSensor(Sensor):
    """Joint states as a sensor."""

    def __init__(self, robot: Robot):
        self._robot = robot

    def read(self) -> JointStates:
        return self._robot.joint_states()


class Vehicle:
    """Drives one robot and reads its sensors; the simulator advances the physics.

    robot: the body; description, settings: what it was made with; missing_sensors: the sensors
    that were left out, and the links for them that the robot does not have.
    """

    def __init__(self, description: Description, settings: RobotSettings, world: World):
        """Load the robot into a world.

        Raises SimulationError when a setting does not fit the robot or the physics; nothing is
        left in the world then.
        """
        step_s = world.step_s
        self.description, self.settings, self._step_s = description, settings, step_s
        self.robot = Robot(description, settings.drive, settings.spawn, world.physics_client_id)
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s, step_s)
        self._drive = DifferentialDrive(settings.drive)
        self._wheel_velocities: Optional[Tuple[float, float]] = None    # that the motors have
        periods = settings.sensors
        # a generator each: the noise of one sensor does not depend on whether the other is read
        scan_noise, imu_noise = (np.random.RandomState((periods.seed, number))
                                 for number in range(2))
        sensors: Dict[str, Sensor] = {
            'odometry': make_odometry(self.robot, settings.odometry, settings.drive,
                                      periods.odometry_period_s),
            'joint_states': _JointStateSensor(self.robot)}
        self.missing_sensors: Dict[str, str] = {}
        if self._can_have('imu', settings.imu.imu_frame, ImuSettings().imu_frame):
            sensors['imu'] = Imu(self.robot, settings.imu, periods.imu_period_s, imu_noise)
        if self._can_have('scan', settings.scan.scan_frame, ScanSettings().scan_frame):
            sensors['scan'] = LaserScanner(self.robot, settings.scan, scan_noise, world.solids)
        self._sensors = {name: ScheduledSensor(name, self._period_steps(name, step_s), sensor)
                         for name, sensor in sensors.items()}
        self._enabled = list(self._sensors.values())

    def _can_have(self, sensor: str, frame: str, default_frame: str) -> bool:
        """Return whether to mount a sensor: not when only the default names a missing link."""
        if frame == default_frame and not self.robot.has_frame(frame):
            self.missing_sensors[sensor] = frame
            return False
        return True

    def mount_camera(self, settings: CameraSettings, poses: Callable[[], np.ndarray]) -> str:
        """Add a camera, which is disabled; return the name of the sensor.

        poses: returns the poses (n, 7) of all parts of the scene.
        Raises SimulationError when the robot has no link for it.
        """
        name = 'camera_{}'.format(sum(isinstance(each.sensor, RobotCamera)
                                      for each in self._sensors.values()))
        camera = RobotCamera(self.robot, settings, poses)
        period_s = nearest_period(settings.camera_rate, self._step_s)
        self._sensors[name] = ScheduledSensor(
            name, whole_steps('camera_rate', period_s, self._step_s), camera)
        self._sensors[name].enabled = False
        return name

    def _period_steps(self, sensor: str, step_s: float) -> int:
        name = sensor + '_period_s'
        return whole_steps(name, getattr(self.settings.sensors, name), step_s)

    def set_sensor_enabled(self, sensor: str, enabled: bool) -> None:
        """Enable or disable a sensor; does nothing when the robot does not have it.

        Sensors do not influence how the robot moves.
        """
        scheduled = self._sensors.get(sensor)
        if scheduled is None or scheduled.enabled == enabled:
            return
        if enabled:
            scheduled.sensor.restart()
        scheduled.enabled = enabled
        self._enabled = [each for each in self._sensors.values() if each.enabled]

    def command(self, linear_x: float, angular_z: float) -> None:
        """Drive at linear_x m/s and angular_z rad/s until the next command."""
        self._drive.command(linear_x, angular_z)

    def scale_command_timeout(self, factor: float) -> None:
        """Make `cmd_vel_timeout` this many times as long as it is in the settings."""
        self._drive.scale_timeout(factor)

    @property
    def command_timeout_s(self) -> float:
        """The `cmd_vel_timeout` as it is scaled."""
        return self._drive.timeout_s

    @property
    def odometry_origin(self) -> Tuple[float, float, float]:
        """Where the odometry is zero: x, y in m and yaw in rad, in the world."""
        if self.settings.odometry.odometry_source == WORLD:
            return 0.0, 0.0, 0.0
        spawn = self.settings.spawn
        return spawn.x_pos, spawn.y_pos, spawn.yaw

    @property
    def command_timed_out(self) -> bool:
        """Whether the robot stops because no command came for `cmd_vel_timeout`."""
        return self._drive.timed_out

    def before_step(self, steps: int) -> None:
        """Set the motors if the drive is due after `steps` steps of the physics."""
        if steps % self._drive_steps == 0:
            velocities = self._drive.update(self.robot.wheel_velocities)
            if velocities != self._wheel_velocities:
                self._wheel_velocities = velocities
                self.robot.set_wheel_velocities(velocities)

    def due_sensors(self, steps: int) -> List[ScheduledSensor]:
        """Return the sensors that are to be read after `steps` steps."""
        return [scheduled for scheduled in self._enabled if steps % scheduled.period_steps == 0]

    def next_event(self, steps: int) -> int:
        """Return the first step after `steps` at which the drive or a sensor is due."""
        wait = self._drive_steps - steps % self._drive_steps
        for scheduled in self._enabled:
            remaining = scheduled.period_steps - steps % scheduled.period_steps
            if remaining < wait:
                wait = remaining
        return steps + wait

    def reset(self) -> None:
        """Move the robot back to its start, at rest and without a command."""
        self._drive.reset()
        self.robot.reset()
        self._wheel_velocities = None
        for scheduled in self._sensors.values():
            scheduled.sensor.restart()

    def set_start(self, spawn: SpawnSettings) -> None:
        """Start from another pose, also after a reset; moves the robot there."""
        self.settings = dataclasses.replace(self.settings, spawn=spawn)
        self.robot.spawn = spawn
        self.reset()

    def move_to(self, x: float, y: float, yaw: float) -> None:
        """Move the robot to x, y in m and yaw in rad, at rest and without a command.

        It stands at the height of its start.
        """
        self._drive.reset()
        self.robot.place(Pose((x, y, self.settings.spawn.z_pos),
                              rotations.of_yaw(yaw), self.robot.pose().joints))
        self.robot.set_wheel_velocities((0.0, 0.0))
        self.notify_teleported()

    def notify_teleported(self) -> None:
        """Call after the robot was moved from outside: the IMU must not see an acceleration.

        Odometry from the wheels is not changed: they did not turn.
        """
        self._wheel_velocities = None
        if 'imu' in self._sensors:
            self._sensors['imu'].sensor.restart()
