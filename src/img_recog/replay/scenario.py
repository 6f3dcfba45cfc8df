"""The world and robot of a replay, built without a parameter server."""
import dataclasses
import logging
from types import MappingProxyType
from typing import Any, Mapping

from img_recog.camera_arguments import FRAME, ROBOT_LINK
from img_recog.conversions.sensor_table import SENSORS
from img_recog.errors import UserError
from img_recog.loading import assemble
from img_recog.replay.recorders import RECORDED
from img_recog.simulation.simulation_settings import (CameraSettings, NoiseSettings,
                                                      PhysicsSettings, SpawnSettings)
from img_recog.simulation.simulator import Simulator

_log = logging.getLogger(__name__)
_UNUSED_SENSORS = [kind.name for kind in SENSORS if kind.name not in RECORDED]


def build(world: str, urdf_path: str, spawn: SpawnSettings,
          allow_partial_world: bool = False, drive: Mapping[str, Any] = MappingProxyType({}),
          noise: NoiseSettings = NoiseSettings()) -> Simulator:
    """Return a robot in a world, both as in the demo.

    world, urdf_path, allow_partial_world: like the launch arguments. drive: settings of the drive
    that are not those of the URDF, by name. Logs the warnings.
    Raises UserError when something cannot be read or built.
    """
    physics = PhysicsSettings(world=world, allow_partial_world=allow_partial_world)
    robot = assemble.robot(urdf_path, '--urdf')
    simulator = assemble.simulator(
        physics, [robot.changed(spawn=spawn, noise=noise, drive=dataclasses.replace(
            robot.settings.drive, **drive))], _UNUSED_SENSORS, _option)
    for line in simulator.world.report.lines():
        _log.warning('%s', line)
    return simulator


def camera_settings(simulator: Simulator) -> CameraSettings:
    """Return the camera of the robot: the first in its URDF, else one on its link camera_link.

    Raises UserError if it has neither.
    """
    robot, = simulator.robots
    if robot.spec.cameras:
        return robot.spec.cameras[0]
    if robot.body.has_frame(ROBOT_LINK):
        return CameraSettings(camera_frame=ROBOT_LINK, camera_optical_frame=FRAME)
    raise UserError('--camera robot: the robot has no camera: neither a <sensor type="camera"> in '
                    'its URDF nor a link ' + ROBOT_LINK, 'add one of them, or set --urdf to a '
                    'robot that has one')


def _option(setting: str) -> str:
    """Return the name of the command line's option for a setting."""
    return '--' + setting.replace('_', '-')
