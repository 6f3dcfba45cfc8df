"""Robots of ros_control, whose drive is on the parameter server."""
import pytest
from geometry_msgs.msg import Twist, TwistStamped, Vector3

from img_recog_helpers import wire
from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.wheeled import controllers, plugin, robot

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


def drive(ros, topic, message):
    """Publish a message to each subscriber of a topic, once."""
    ros.stack.callback(wire.RawPublisher(ros.master_uri, topic, type(message), '/driver',
                                         first=message).close)


def is_near(wanted):
    return lambda value: abs(value - wanted) < 0.02 * abs(wanted)


@pytest.mark.parametrize('space, is_stamped', [('', False), ('/wheels', True)])
def test_the_topics_of_a_controller_are_in_its_namespace(ros, simulate, space, is_stamped):
    given = controllers(use_stamped_vel=is_stamped, cmd_vel_timeout=100.0)['base']
    ros.set_parameters(space + '/base', given)
    try:
        node = simulate(urdf=robot(plugin('gazebo_ros_control', robotNamespace=space or '/')))
        command = Twist(Vector3(x=0.3), Vector3(z=0.0))
        drive(ros, space + '/base/cmd_vel',
              TwistStamped(twist=command) if is_stamped else command)
        Echo(ros, space + '/base/odom/twist/twist/linear/x').wait(is_near(0.3), '0.3 m/s')
        assert node.interrupt() == 0
    finally:
        ros.set_parameters(space + '/base')


def test_without_the_parameters_one_line_says_what_is_missing(simulate):
    node = simulate(urdf=robot(plugin('gazebo_ros_control')))
    node.wait_output('it does not drive, as it has no drive that is simulated; it has: '
                     r'plugin libgazebo_ros_control\.so.*'
                     'whose parameters are loaded before the node starts')
    assert node.interrupt() == 0


def test_a_planar_base_takes_all_of_a_twist(ros, simulate):
    node = simulate(urdf=robot(plugin('gazebo_ros_planar_move')))
    drive(ros, '/cmd_vel', Twist(Vector3(x=0.1, y=0.2), Vector3()))
    Echo(ros, '/odom/twist/twist/linear/y').wait(is_near(0.2), '0.2 m/s to the left')
    assert node.interrupt() == 0
