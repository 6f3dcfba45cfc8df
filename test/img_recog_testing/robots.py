"""The robot and worlds that the simulation's tests share."""
import os

from img_recog.simulation import description, loading, world_file
from img_recog.simulation.settings import PhysicsSettings, RobotSettings, SpawnSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle
from img_recog.simulation.world import World

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'urdf')
WORLDS = {'turtlebot3_world': os.path.join(FOLDER, 'turtlebot3_world.urdf')}


def burger():
    """Return the URDF of the burger."""
    with open(os.path.join(FOLDER, 'turtlebot3_burger.urdf')) as file:
        return file.read()


def simulator(world_name='empty', x=0.0, y=0.0, yaw=0.0, z=0.0, urdf=None, **settings):
    """Return a simulator of the burger in a client of its own."""
    client, physics = loading.connect(), PhysicsSettings(world=world_name)
    world = World(physics, world_file.read(world_name, WORLDS), client)
    settings = RobotSettings(spawn=SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw), **settings)
    robot = description.parse(burger() if urdf is None else urdf)
    return Simulator(world, [Vehicle(robot, settings, physics.step_s, client)])
