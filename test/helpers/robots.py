"""The robot and worlds that the simulation's tests share."""
import dataclasses
import functools
import os

from img_recog.conversions.sensor_table import CAMERA, SENSORS
from img_recog.formats import world_file
from img_recog.formats.markup import read_bytes
from img_recog.simulation import assembly
from img_recog.simulation.configured_model import from_urdf
from img_recog.simulation.simulation_settings import PhysicsSettings, RobotSettings, SpawnSettings

GROUPS = 'spawn', 'drive', 'noise'
FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'urdf')
WORLDS = {'turtlebot3_world': os.path.join(FOLDER, 'turtlebot3_world.urdf')}


def burger(tags=None):
    """Return the URDF of the burger; tags: in place of those of its drive and its sensors."""
    with open(os.path.join(FOLDER, 'turtlebot3_burger.urdf')) as file:
        text = file.read()
    return text if tags is None else (
        text.split('  <!-- Drive and sensors')[0] + tags + '</robot>')


def burgers_drive(**changed):
    """Return the settings of the burger's drive, some of them changed."""
    return dataclasses.replace(read(burger()).settings.drive, **changed)


def burgers(sensor, **changed):
    """Return the settings of one of the burger's sensors, some of them changed."""
    return dataclasses.replace(read(burger()).settings.sensors[sensor], **changed)


def assemble(world_name='empty', x=0.0, y=0.0, yaw=0.0, z=0.0, urdf=None, find_mesh=None,
             allow_partial=False, unused_sensors=(), option_name=str, cameras=(), **settings):
    """Return a simulator of a robot, by default the burger, in a world; **settings: see below.

    world_name: a name, a path or the text of the file.
    """
    robot = read(burger() if urdf is None else urdf, 'robot_description', find_mesh)
    robot = robot._replace(settings=settings_of(
        x, y, yaw, z, **{**robot.settings.sensors, **settings}))
    for camera in cameras:
        robot = robot.with_sensor(CAMERA, camera)
    return build(world_name, [robot], unused_sensors, option_name, allow_partial)


def build(world_name, specs, unused_sensors=(), option_name=str, allow_partial=False):
    """Return a simulator of robots in a world."""
    text = world_name if world_name.startswith('<') else ''
    world_name = 'hall.world' if text else world_name
    world = world_file.read(world_name, WORLDS, allow_partial=allow_partial,
                            read_file=(lambda path: text) if text else read_bytes)
    return assembly.build(PhysicsSettings(world=world_name), world, specs, unused_sensors,
                          option_name)


@functools.lru_cache(maxsize=16)         # it takes as long as the rest of a simulator
def read(urdf, source='robot.urdf', find_mesh=None):
    """Return what the text of a URDF gives."""
    return from_urdf(urdf, PhysicsSettings().step_s, find_mesh or (lambda uri: None), source,
                     SENSORS)


def settings_of(x=0.0, y=0.0, yaw=0.0, z=0.0, **settings):
    """Return the settings of a robot; **settings: those of the drive, the noise and sensors, by
    default of the burger.
    """
    groups = {name: settings.pop(name) for name in GROUPS if name in settings}
    groups.setdefault('drive', burgers_drive())
    groups.setdefault('spawn', SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw))
    return RobotSettings(sensors={**read(burger()).settings.sensors, **settings}, **groups)
