"""Worlds and robots in files, and simulators of them: for the node, programs and tools alike."""
from typing import Callable, Sequence

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import drive_controllers, world_file
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.world_file import WorldFile
from img_recog.loading import resources, robot_file
from img_recog.settings import from_mapping
from img_recog.simulation import assembly, configured_model
from img_recog.simulation.configured_model import ReadSettings, ConfiguredModel
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator

OptionName = Callable[[str], str]
_STEP_S = PhysicsSettings().step_s


def world(name: str, allow_partial: bool = True,
          option: str = 'allow_partial_world:=true') -> WorldFile:
    """Return a world; arguments and errors as for world_file.read."""
    return world_file.read(name, resources.worlds(), resources.find, allow_partial, option,
                           robot_file.read_any)


def robot(path: str, option: str = 'FILE',
          controllers: FindControllers = drive_controllers.none) -> ConfiguredModel:
    """Return the robot in a URDF or xacro file, with the settings of its tags.

    option: what the user types to name the file. controllers: see configured_model.from_urdf.
    Raises UserError when it cannot be used.
    """
    return robot_of(robot_file.read(path, option), path, _STEP_S, controllers)


def robot_of(urdf: str, source: str, step_s: float = _STEP_S,
             controllers: FindControllers = drive_controllers.none,
             read: ReadSettings = from_mapping) -> ConfiguredModel:
    """Return the robot in the text of a URDF; arguments and errors as for
    configured_model.from_urdf.
    """
    return configured_model.from_urdf(urdf, step_s, resources.find, source, SENSORS, controllers,
                                      read)


def simulator(physics: PhysicsSettings, robots: Sequence[ConfiguredModel] = (),
              unused_sensors: Sequence[str] = (), option_name: OptionName = str,
              with_sensors: bool = False, with_bare: bool = False,
              with_drives: bool = False) -> Simulator:
    """Return a simulator of robots in the world that the settings name.

    with_sensors: whether models of the world have the sensors in their files; other arguments and
    errors as for assembly.build.
    """
    option = option_name('allow_partial_world')
    file = world(physics.world, physics.allow_partial_world,
                 option if option.startswith('-') else option + ':=true')
    return assembly.build(physics, file, robots, unused_sensors, option_name,
                          SENSORS if with_sensors else (), with_bare, with_drives)
