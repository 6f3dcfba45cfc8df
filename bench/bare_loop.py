"""Measure the steps per second of PyBullet alone, with the world and the robot of the node."""
import os
import time

from ros_processes import answer

from img_recog.formats import world_file
from img_recog.loading import assemble
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulated_model import Robot

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, 'urdf')
BATCH = 1000


def steps_per_s(world: World, seconds: float) -> float:
    """Simulate for so many seconds of wall time."""
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        world.step(BATCH)
        steps += BATCH
    return steps / (time.perf_counter() - start)


def main() -> None:
    """Answer the lines of the input."""
    worlds = {'turtlebot3_world': os.path.join(FOLDER, 'turtlebot3_world.urdf')}
    client, physics = connect(), PhysicsSettings()
    world = World(physics, world_file.read('turtlebot3_world', worlds), client)
    robot = Robot(assemble.robot(os.path.join(FOLDER, 'turtlebot3_burger.urdf')), world)
    # the speeds of drive_sample.py, without a ramp: 0.02 m/s and 0.5 rad/s
    robot.body.set_wheel_velocities(((0.02 - 0.04) / 0.033, (0.02 + 0.04) / 0.033))
    world.step(BATCH)
    answer(lambda seconds: steps_per_s(world, seconds))


if __name__ == '__main__':
    main()
