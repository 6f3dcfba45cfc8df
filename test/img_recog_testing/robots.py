"""The robot and worlds that the simulation's tests share."""
import os

from img_recog.simulation import assembly
from img_recog.simulation.descriptions import world_file
from img_recog.simulation.settings import PhysicsSettings, RobotSettings, SpawnSettings

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'urdf')
WORLDS = {'turtlebot3_world': os.path.join(FOLDER, 'turtlebot3_world.urdf')}


def burger():
    """Return the URDF of the burger."""
    with open(os.path.join(FOLDER, 'turtlebot3_burger.urdf')) as file:
        return file.read()


def assemble(world_name='empty', x=0.0, y=0.0, yaw=0.0, z=0.0, urdf=None, find_mesh=None,
             allow_partial=False, **settings):
    """Return the assembly of a robot, by default the burger, in a world; **settings: its groups.
    """
    physics = PhysicsSettings(world=world_name)
    robot = assembly.read_robot(burger() if urdf is None else urdf, physics.step_s,
                                find_mesh or (lambda uri: None), 'robot_description')
    spawn = SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw)
    world = world_file.read(world_name, WORLDS, allow_partial=allow_partial)
    return assembly.build(physics, world, [(robot, RobotSettings(spawn=spawn, **settings))])


def simulator(*args, **kwargs):
    """Return the simulator alone; arguments as for `assemble`."""
    return assemble(*args, **kwargs).simulator
