"""How many files of ours a value passes through: those that a reader has to open."""
import json
import os
import sys

from img_recog_helpers import followed_value
from img_recog_helpers.simulator_tools import Echo, burger, drive

SCRIPTS = os.path.join(followed_value.PACKAGE, '..', '..', 'scripts')
SPEED, WHEEL_RADIUS = 0.12345678901, 0.033


def follow(ros, tmp_path, numbers, script, *arguments):
    """Start a script; return its process, and a function that ends it and returns the files."""
    result = tmp_path / 'files.json'
    node = ros.start(sys.executable, followed_value.__file__, result,
                     ','.join(map(repr, numbers)), os.path.join(SCRIPTS, script), *arguments)

    def files():
        assert node.interrupt() == 0, node.output
        return json.loads(result.read_text())
    return node, files


def test_a_command_reaches_the_wheels_through_eight_files(shared_ros, tmp_path):
    shared_ros.set_parameters('/robot_description', burger())
    node, files = follow(shared_ros, tmp_path, (SPEED, SPEED / WHEEL_RADIUS), 'pybullet_sim.py',
                         '__name:=gazebo')
    node.wait_output('simulating 1')
    drive(shared_ros, SPEED)
    odometry = Echo(shared_ros, '/odom/twist/twist/linear/x')
    odometry.wait(lambda speed: speed > 0.9 * SPEED, 'the robot drives')
    odometry.close()
    assert files() == [
        'conversions/twist_msgs.py', 'nodes/gazebo/gazebo_node.py', 'nodes/gazebo/model_topics.py',
        'ros/queues.py', 'simulation/physics/drive.py', 'simulation/physics/robot.py',
        'simulation/simulated_model.py', 'simulation/simulator.py']
