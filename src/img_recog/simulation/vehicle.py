"""A robot with its drive and its sensors."""
from typing import Any, List, NamedTuple

import numpy as np

from img_recog.simulation.description import Description
from img_recog.simulation.device import Device
from img_recog.simulation.differential_drive import DifferentialDrive
from img_recog.simulation.imu import Imu
from img_recog.simulation.laser_scanner import LaserScanner
from img_recog.simulation.odometry import make_odometry
from img_recog.simulation.robot import JointStates, Robot
from img_recog.simulation.settings import ImuSettings, RobotSettings, ScanSettings, whole_steps


class Reading(NamedTuple):
    """What a sensor of a robot saw: names, the simulated time in s, its own kind of value."""

    robot: str
    sensor: str
    time_s: float
    value: Any


class _Sensor:
    """A device that observes once a period while it is switched on."""

    def __init__(self, name: str, period_steps: int, device: Device):
        self.name, self.period_steps, self.device = name, period_steps, device
        self.on = True


class _Joints(Device):
    """Joint states as a sensor."""

    def __init__(self, robot: Robot):
        self._robot = robot

    def observe(self) -> JointStates:
        return self._robot.joint_states()


class Vehicle:
    """Drives and observes one robot; the physics is somebody else's.

    robot: the body; settings: what it was made with; missing: the sensors that it has no link for.
    """

    def __init__(self, description: Description, settings: RobotSettings, step_s: float,
                 client: int):
        """Put the robot into the world of `client`.

        step_s: of the physics. Raises SimulationError when something cannot be built as asked.
        """
        self.settings = settings
        self.robot = Robot(description, settings.drive, settings.spawn, client)
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s, step_s)
        self._drive = DifferentialDrive(settings.drive)
        periods = settings.sensors
        # a generator each: the noise of one sensor does not hang on who watches the other
        scan_noise, imu_noise = (np.random.RandomState((periods.seed, number))
                                 for number in range(2))
        devices = {
            'odometry': make_odometry(self.robot, settings.odometry, settings.drive,
                                      periods.odometry_period_s),
            'joint_states': _Joints(self.robot)}
        self.missing = []
        if self._has('imu', settings.imu.imu_frame, ImuSettings().imu_frame):
            devices['imu'] = Imu(self.robot, settings.imu, periods.imu_period_s, imu_noise)
        if self._has('scan', settings.scan.scan_frame, ScanSettings().scan_frame):
            devices['scan'] = LaserScanner(self.robot, settings.scan, scan_noise, client)
        self._sensors = {name: _Sensor(name, self._period(name, step_s), device)
                         for name, device in devices.items()}

    def _has(self, sensor: str, frame: str, usual: str) -> bool:
        """Return whether to mount a sensor: not where nobody asked for it and it has no link."""
        if frame == usual and not self.robot.has_frame(frame):
            self.missing.append('{} (no link {})'.format(sensor, frame))
            return False
        return True

    def _period(self, sensor: str, step_s: float) -> int:
        name = sensor + '_period_s'
        return whole_steps(name, getattr(self.settings.sensors, name), step_s)

    def switch(self, sensor: str, on: bool) -> None:
        """Switch a sensor, if there is one, on or off; none changes how the robot moves."""
        if sensor not in self._sensors:
            return
        chosen = self._sensors[sensor]
        if on and not chosen.on:
            chosen.device.restart()
        chosen.on = on

    def command(self, linear_x: float, angular_z: float) -> None:
        """Drive at linear_x m/s and angular_z rad/s until the next command."""
        self._drive.command(linear_x, angular_z)

    def before_step(self, steps: int) -> None:
        """Ask the motors for the speeds that are due after `steps` steps of the physics."""
        if steps % self._drive_steps == 0:
            self.robot.set_wheel_velocities(self._drive.update(self.robot.wheel_velocities()))

    def after_step(self, steps: int, time_s: float) -> List[Reading]:
        """Return what the sensors see whose time has come after `steps` steps."""
        return [Reading(self.robot.name, sensor.name, time_s, sensor.device.observe())
                for sensor in self._sensors.values()
                if sensor.on and steps % sensor.period_steps == 0]

    def next_event(self, steps: int) -> int:
        """Return the number of the next step after `steps` at which there is something to do."""
        periods = [sensor.period_steps for sensor in self._sensors.values() if sensor.on]
        return min(steps - steps % period + period for period in periods + [self._drive_steps])

    def reset(self) -> None:
        """Put the robot back to its start, at rest and without a command."""
        self._drive.reset()
        self.robot.reset()
        for sensor in self._sensors.values():
            sensor.device.restart()

    def moved(self) -> None:
        """Tell that the robot was put elsewhere: no acceleration, and nothing that wheels see."""
        if 'imu' in self._sensors:
            self._sensors['imu'].device.restart()
