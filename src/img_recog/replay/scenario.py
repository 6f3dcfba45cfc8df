"""The world and robot of a replay, built without a parameter server."""
import contextlib
import dataclasses
import logging
from typing import Any, Iterator, Mapping, Sequence

from img_recog import resources
from img_recog.errors import UserError
from img_recog.settings import SettingError, from_mapping
from img_recog.simulation import description, gazebo_tags, loading, meshes, world_file
from img_recog.simulation.settings import (PhysicsSettings, RobotSettings, SimulationError,
                                           SpawnSettings)
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle
from img_recog.simulation.world import World

_log = logging.getLogger(__name__)


def build(world: str, urdf_path: str, spawn: SpawnSettings) -> Simulator:
    """Return the simulator of a robot in a world, both as the demo would have them.

    world: as the launch file's. Logs what is left out of what the files ask for.
    Raises UserError when something cannot be read or built.
    """
    physics = PhysicsSettings(world=world)
    urdf = _text(urdf_path)
    with _named(urdf_path):
        robot = description.parse(urdf, resources.find)
        settings = dataclasses.replace(
            _stated_by(gazebo_tags.settings(urdf, physics.step_s)), spawn=spawn)
    file = world_file.read(world, resources.worlds(), resources.find)
    client = loading.connect()
    simulated = World(physics, file, client)
    with _named(urdf_path):
        vehicle = Vehicle(robot, settings, physics.step_s, client)
    for sensor in ('imu', 'scan'):
        vehicle.switch(sensor, False)
    simulator = Simulator(simulated, [vehicle])
    _warn(simulator, robot, urdf_path, urdf, file.warnings)
    return simulator


@contextlib.contextmanager
def _named(path: str) -> Iterator[None]:
    """Let errors say which file it is: who raises them knows but the text."""
    try:
        yield
    except (SettingError, SimulationError) as error:
        raise UserError('cannot use the robot in {}: {}'.format(
            path, str(error).replace('robot_description', 'it')))


def _text(path: str) -> str:
    if path.endswith('.xacro'):
        raise UserError('cannot use {0}: it is xacro; make a URDF of it: xacro {0} > robot.urdf'
                        .format(path))
    try:
        with open(path, encoding='utf-8') as file:
            return file.read()
    except (OSError, ValueError) as error:
        raise UserError('cannot read the robot in {}: {}; set --urdf to a URDF file'.format(
            path, getattr(error, 'strerror', None) or 'it is no text'))


def _stated_by(values: Mapping[str, Any]) -> RobotSettings:
    """Return the settings with what <gazebo> tags state in the place of defaults."""
    return RobotSettings(**{field.name: from_mapping(type(field.default), values)
                            for field in dataclasses.fields(RobotSettings)})


def _warn(simulator: Simulator, robot: description.Description, path: str, urdf: str,
          warnings: Sequence[str]) -> None:
    if robot.missing_meshes:
        _log.warning('%s: %s', path, meshes.described(robot.missing_meshes))
    strange = gazebo_tags.not_simulated(urdf)
    if strange:
        _log.warning('%s: <gazebo> tags that this simulator has nothing for: %s', path,
                     ', '.join(strange))
    for warning in warnings:
        _log.warning('%s', warning)
    for overlap in simulator.overlaps():
        _log.warning('%s: the robot starts inside of what it will be thrown out of; set --x-pos, '
                     '--y-pos, --z-pos', overlap)
