"""World, robot, drive and sensors, advanced together by whole steps."""
from typing import Any, Callable, Dict, List, NamedTuple

import numpy as np

from img_recog.simulation.description import Description
from img_recog.simulation.differential_drive import DifferentialDrive
from img_recog.simulation.imu import Imu
from img_recog.simulation.laser_scanner import LaserScanner
from img_recog.simulation.robot import Robot
from img_recog.simulation.settings import SimulatorSettings, whole_steps
from img_recog.simulation.world import World


class Reading(NamedTuple):
    """What a sensor saw: its name, the simulated time in s, and its own kind of value."""

    sensor: str
    time_s: float
    value: Any


class _Sensor(NamedTuple):
    """A sensor is a name, a period in steps and a function that looks at the robot."""

    name: str
    period_steps: int
    observe: Callable[[], Any]


class Simulator:
    """One robot in one world.

    Each step has a fixed order: the drive asks the motors, the physics advances, and the sensors
    whose time has come observe. Time is the number of steps times the step.
    """

    def __init__(self, description: Description, worlds: Dict[str, str], client: int,
                 settings: SimulatorSettings = SimulatorSettings()):
        """Build world and robot in the PyBullet client `client`.

        worlds: see World. Raises SimulationError when something cannot be built as asked.
        """
        self._step_s = settings.physics.step_s
        self._steps = 0
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s,
                                        self._step_s)
        self._world = World(settings.physics, worlds, client)
        self.robot = Robot(description, settings.drive, settings.spawn, client)
        self._drive = DifferentialDrive(settings.drive)
        self._sensors: List[_Sensor] = []
        self._add_sensors(settings, client)

    def _add_sensors(self, settings: SimulatorSettings, client: int) -> None:
        periods = settings.sensors
        noise = np.random.RandomState(periods.seed)
        scanner = LaserScanner(self.robot, settings.scan, noise, client)
        self._imu = Imu(self.robot, settings.imu, periods.imu_period_s, noise)
        self.add_sensor('odometry', periods.odometry_period_s, self.robot.motion)
        self.add_sensor('joint_states', periods.joint_states_period_s, self.robot.joint_states)
        self.add_sensor('imu', periods.imu_period_s, self._imu.observe)
        self.add_sensor('scan', periods.scan_period_s, scanner.observe)

    @property
    def time_s(self) -> float:
        """The simulated time."""
        return self._steps * self._step_s

    def add_sensor(self, name: str, period_s: float, observe: Callable[[], Any]) -> None:
        """Call `observe` once every `period_s` and hand on what it returns as a Reading.

        Raises SimulationError when the period does not divide into steps.
        """
        steps = whole_steps(name + '_period_s', period_s, self._step_s)
        self._sensors.append(_Sensor(name, steps, observe))

    def command(self, linear_x: float, angular_z: float) -> None:
        """Drive at linear_x m/s and angular_z rad/s until the next command."""
        self._drive.command(linear_x, angular_z)

    def advance(self, steps: int) -> List[Reading]:
        """Advance by a number of steps; return what the sensors saw meanwhile, in order."""
        readings: List[Reading] = []
        for _ in range(steps):
            if self._steps % self._drive_steps == 0:
                self.robot.set_wheel_velocities(
                    self._drive.update(self.robot.wheel_velocities()))
            self._world.step()
            self._steps += 1
            for sensor in self._sensors:
                if self._steps % sensor.period_steps == 0:
                    readings.append(Reading(sensor.name, self.time_s, sensor.observe()))
        return readings

    def reset_world(self) -> None:
        """Put the robot back to its start, at rest and without a command; time goes on."""
        self._drive.reset()
        self.robot.reset()
        self._imu.reset()

    def reset_simulation(self) -> None:
        """Put the robot back to its start and the time to 0."""
        self.reset_world()
        self._steps = 0
