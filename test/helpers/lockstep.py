"""Runs of a user's node in lockstep with the simulator, and the path that it drives."""
import contextlib
import hashlib
import shutil
import subprocess
import sys

from img_recog_helpers.simulator_tools import Echo, burger
from img_recog_helpers.waiting import wait_for

# a busy machine may need longer than the default of 5 s to start a node again
PATIENT = '_lockstep_timeout:=90'
CAMERA = ('_camera_frame:=camera_link', '_camera_image_topic:=image_raw', '_camera_width:=64',
          '_camera_height:=48', '_world:=color_posts')
# turns until it sees blue, then drives there; a command for each image
NODE = r'''
import sys, time
import numpy, rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image

def answer(msg):
    pixels = numpy.frombuffer(msg.data, 'u1').reshape(msg.height, msg.width, 3).astype(int)
    rows, columns = numpy.nonzero(pixels[..., 2] > pixels[..., :2].max(2) + 60)
    command = Twist()
    command.linear.x = 0.2 if len(columns) else 0.0
    command.angular.z = 1 - columns.mean() / 32 if len(columns) else 1.0
    time.sleep({delay})
    for _ in range({count}):
        velocity.publish(command)

rospy.init_node('{name}')
velocity = rospy.Publisher('{topic}', Twist, queue_size=10)
rospy.Subscriber('image_raw', Image, answer, queue_size=1, buff_size=1 << {buffer_bits})
rospy.spin()
'''
# passes on what another one has found
CONTROLLER = '''
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('controller')
velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
rospy.Subscriber('found', Twist, velocity.publish)
rospy.spin()
'''
# the same in C++
CPP_NODE = r'''
#include <geometry_msgs/Twist.h>
#include <image_transport/image_transport.h>
#include <ros/ros.h>
ros::Publisher velocity;
void answer(const sensor_msgs::ImageConstPtr& msg) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < msg->data.size(); i += 3) {
    const uint8_t* rgb = &msg->data[i];
    if (rgb[2] > std::max(rgb[0], rgb[1]) + 60) { sum += i / 3 % msg->width; ++count; }
  }
  geometry_msgs::Twist command;
  command.linear.x = count ? 0.2 : 0.0;
  command.angular.z = count ? 1 - sum / count / 32 : 1.0;
  velocity.publish(command);
}
int main(int argc, char** argv) {
  ros::init(argc, argv, "driver");
  ros::NodeHandle node;
  velocity = node.advertise<geometry_msgs::Twist>("cmd_vel", 1);
  image_transport::ImageTransport transport(node);
  auto subscriber = transport.subscribe("image_raw", 1, answer);
  ros::spin();
}
'''


class Path(Echo):
    """Where the robot is by its odometry: stamps in ns, poses and velocities."""

    @staticmethod
    def row(msg, fields):
        pose, twist = msg.pose.pose, msg.twist.twist
        return [msg.header.stamp.to_nsec(), pose.position.x, pose.position.y, pose.orientation.z,
                twist.linear.x, twist.angular.z]


class Scans(Echo):
    """What the laser scanner has measured: stamps in ns, and distances with noise."""

    @staticmethod
    def row(msg, fields):
        return [msg.header.stamp.to_nsec(), *msg.ranges]


def compiled(folder):
    """Return the path of the node in C++, None where it cannot be compiled."""
    if shutil.which('g++') is None:
        return None
    source, program = folder / 'driver.cpp', folder / 'driver'
    source.write_text(CPP_NODE)
    libraries = 'roscpp', 'rosconsole', 'roscpp_serialization', 'rostime', 'image_transport'
    done = subprocess.run(['g++', '-o', str(program), str(source),
                           *('-l' + library for library in libraries)],
                          stderr=subprocess.DEVNULL, check=False)
    return None if done.returncode else program


def driver(ros, name='driver', delay='0', count=1, buffer_bits=24, topic='cmd_vel', robot=''):
    """Start the node. delay: an expression, s for each image; count: of commands for each."""
    return ros.start(sys.executable, '-c', NODE.format(
        name=name, delay=delay, count=count, buffer_bits=buffer_bits, topic=topic),
        '__ns:=/' + robot)


def controller(ros):
    """Start the node that passes commands on from the topic found."""
    return ros.start(sys.executable, '-c', CONTROLLER)


def path(ros, *parameters, start=driver, images=40, disturb=lambda node, process, rows: None):
    """Return where the robot was at each of its first images, and the scans of that time.

    parameters: of the simulator; start: start(ros) starts the node that drives; disturb: is called
    when both run.
    """
    ros.set_parameters('/gazebo')
    ros.set_parameters('/robot_description', burger())
    node = ros.start_node('pybullet_sim.py', *CAMERA, '_camera_noise:=0.02',
                          '_lockstep:=cmd_vel', PATIENT, *parameters)
    echo, scan, scans = Path(ros, '/odom'), Scans(ros, '/scan'), images // 7
    with contextlib.closing(echo), contextlib.closing(scan):
        wait_for(lambda: echo.is_connected.is_set() and scan.is_connected.is_set(),
                 lambda: node.output)
        process = start(ros)
        disturb(node, process, echo.rows)
        wait_for(lambda: len(echo.rows) > images and len(scan.rows) > scans,
                 lambda: node.output[-800:] + process.output)
    _end(ros, process, node)
    return _checked(echo.rows[:images], -2.0, -0.5) + scan.rows[:scans]


def paths_of_two(ros, *delays, images=30):
    """Return where two robots were, each with a node that drives; delays: of the nodes."""
    places = {'tb3_0': (-2.0, -0.5), 'tb3_1': (-1.0, 0.3)}
    ros.set_parameters('/gazebo', {'robots': {
        name: {'x_pos': x, 'y_pos': y} for name, (x, y) in places.items()}})
    ros.set_parameters('/robot_description', burger())
    node = ros.start_node('pybullet_sim.py', *CAMERA, '_several_robots:=true',
                          '_lockstep:=tb3_0/cmd_vel tb3_1/cmd_vel', '_real_time_factor:=0',
                          PATIENT)
    with contextlib.ExitStack() as stack:
        echoes = [stack.enter_context(contextlib.closing(Path(ros, '/{}/odom'.format(name))))
                  for name in places]
        for echo in echoes:
            wait_for(echo.is_connected.is_set, lambda: node.output)
        drivers = [driver(ros, delay=delay, robot=name) for name, delay in zip(places, delays)]
        wait_for(lambda: all(len(echo.rows) > images for echo in echoes),
                 lambda: node.output[-800:] + drivers[0].output)
    _end(ros, *drivers, node)
    return [_checked(echo.rows[:images], *place) for echo, place in zip(echoes, places.values())]


def _end(ros, *processes):
    """End processes, the simulator last."""
    for each in processes[:-1]:
        each.close()
    assert processes[-1].interrupt() == 0
    for each in processes:
        ros.processes.remove(each)


def _checked(rows, x, y):
    """Return the rows of a path, which must be complete and begin at a place."""
    assert [row[0] for row in rows] == [33000000 * number for number in range(1, len(rows) + 1)]
    assert (rows[0][1] - x) ** 2 + (rows[0][2] - y) ** 2 < 1e-4
    assert max(abs(value) for value in rows[-1][4:]) > 0.1       # it drives or turns
    return rows


def digest(rows):
    """Return a hash of a path."""
    return hashlib.sha256(repr(rows).encode()).hexdigest()
