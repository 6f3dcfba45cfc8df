"""The robot and worlds that the simulation's tests share."""
import os

from img_recog.simulation import description, world
from img_recog.simulation.settings import PhysicsSettings, SimulatorSettings, SpawnSettings
from img_recog.simulation.simulator import Simulator

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'urdf')
WORLDS = {'turtlebot3_world': os.path.join(FOLDER, 'turtlebot3_world.urdf')}


def burger():
    """Return the URDF of the burger."""
    with open(os.path.join(FOLDER, 'turtlebot3_burger.urdf')) as file:
        return file.read()


def simulator(world_name='empty', x=0.0, y=0.0, yaw=0.0, **settings):
    """Return a simulator of the burger in a client of its own."""
    return Simulator(description.parse(burger()), WORLDS, world.connect(), SimulatorSettings(
        physics=PhysicsSettings(world=world_name),
        spawn=SpawnSettings(x_pos=x, y_pos=y, yaw=yaw), **settings))
