"""./run manual: what is missing is one line; the whole of slam, with a mapper of this test."""
import re

import pytest

from img_recog_testing.manual import Workspace
from img_recog_testing.reliability.parts import PARTS, Options

LAUNCH = """<launch>
  <arg name="model"/><arg name="slam_methods"/><arg name="open_rviz"/>
  <node name="robot_state_publisher" pkg="robot_state_publisher" type="robot_state_publisher"/>
  <node name="mapper" pkg="gmapping" type="mapper.py" output="screen"/>
</launch>"""
# marks what the scans hit, and wants of the simulator what gmapping wants
MAPPER = """#!{python}
import numpy as np
import rospy
import tf2_ros
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan

rospy.init_node('mapper')
buffer = tf2_ros.Buffer()
tf2_ros.TransformListener(buffer)
cells = np.full((160, 160), -1, np.int8)
grids = rospy.Publisher('map', OccupancyGrid, queue_size=1)
while not rospy.is_shutdown():
    scan = rospy.wait_for_message('scan', LaserScan)
    assert scan.header.frame_id == 'base_scan'
    while rospy.Time.now() < scan.header.stamp:     # the clock has another connection
        rospy.rostime.wallsleep(0.001)
    assert len(scan.ranges) == round((scan.angle_max - scan.angle_min) / scan.angle_increment) + 1
    try:
        at = buffer.lookup_transform('odom', 'base_scan', scan.header.stamp, rospy.Duration(1))
    except tf2_ros.TransformException as error:
        rospy.logwarn(str(error))
        continue
    where, turn = at.transform.translation, at.transform.rotation
    yaw = 2 * np.arctan2(turn.z, turn.w)
    ranges = np.array(scan.ranges)
    angles = yaw + scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
    seen = (ranges > scan.range_min) & (ranges < 2.0)
    x = where.x + ranges[seen] * np.cos(angles[seen])
    y = where.y + ranges[seen] * np.sin(angles[seen])
    cells[((y + 4) / 0.05).astype(int), ((x + 4) / 0.05).astype(int)] = 100
    grid = OccupancyGrid(data=cells.ravel().tolist())
    grid.header.frame_id, grid.header.stamp = 'map', rospy.Time.now()
    grid.info.width = grid.info.height = 160
    grid.info.resolution = 0.05
    grid.info.origin.position.x = grid.info.origin.position.y = -4
    grids.publish(grid)
"""


# a map that is turned by 4 degrees about the start, where this move_base sets the robot down
NAVIGATION = """#!{python}
import math
import numpy as np
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid

TURN, START = math.radians(4), np.array((-2.0, -0.5))
turn = np.array(((math.cos(TURN), -math.sin(TURN)), (math.sin(TURN), math.cos(TURN))))
rospy.init_node('navigation')
grid = OccupancyGrid()
grid.header.frame_id = 'map'
grid.info.width = grid.info.height = 160
grid.info.resolution = 0.05
grid.info.origin.position.x = grid.info.origin.position.y = -4
cells = np.zeros((160, 160), np.int8)
angles = np.radians(range(360))
for pillar in ((x, y) for x in (-1.1, 0, 1.1) for y in (-1.1, 0, 1.1)):
    x, y = turn @ (pillar - START) + START
    cells[((y + 0.15 * np.sin(angles) + 4) / 0.05).astype(int),
          ((x + 0.15 * np.cos(angles) + 4) / 0.05).astype(int)] = 100
grid.data = cells.ravel().tolist()
grids = rospy.Publisher('map', OccupancyGrid, queue_size=1, latch=True)
grids.publish(grid)
poses = rospy.Publisher('amcl_pose', PoseWithCovarianceStamped, queue_size=1)
robot = rospy.Publisher('gazebo/set_pose', PoseStamped, queue_size=1)
rospy.Subscriber('initialpose', PoseWithCovarianceStamped, poses.publish)
states = []
status = rospy.Publisher('move_base/status', GoalStatusArray, queue_size=1)

def drive(goal):
    place = np.array((goal.pose.position.x, goal.pose.position.y))
    x, y = turn.T @ (place - START) + START
    goal.header.frame_id = 'odom'
    goal.pose.position.x, goal.pose.position.y = x, y
    robot.publish(goal)
    rospy.sleep(0.5)
    states.append(GoalStatus(GoalID(id=str(x)), GoalStatus.SUCCEEDED, ''))

rospy.Subscriber('move_base_simple/goal', PoseStamped, drive)
while not rospy.is_shutdown():
    status.publish(GoalStatusArray(status_list=states))
    rospy.sleep(0.1)
"""


@pytest.fixture
def workspace(ros, tmp_path):
    return Workspace(tmp_path, ros.env)


def test_packages_that_are_missing_are_named_in_one_line(workspace, tmp_path):
    workspace.add('gmapping', 'turtlebot3_slam')
    code, output = workspace.manual('slam', '--dir', tmp_path)
    assert code == 1
    line, = [line for line in output.splitlines() if 'missing' in line]
    assert line.startswith('[run] these packages of ROS are missing: turtlebot3_bringup '
                           'turtlebot3_description; ')


def test_the_long_test_skips_chapters_whose_packages_or_map_are_missing(workspace, monkeypatch):
    workspace.add('amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
                  'turtlebot3_description', 'turtlebot3_navigation')
    monkeypatch.setenv('ROS_PACKAGE_PATH', workspace.env['ROS_PACKAGE_PATH'])
    rows = [row[:2] for row in PARTS['manual'](Options(seed=0))]
    results = dict(rows)
    assert list(results) == ['slam', 'navigation', 'dqn', 'autorace'] and len(rows) == 4
    assert results.pop('navigation').startswith('skipped: there is no map '), rows
    assert all(result.startswith('skipped: these packages of ROS are missing: ')
               for result in results.values()), rows


def test_a_package_without_its_nodelets_is_missing(workspace):
    workspace.add('image_proc', 'turtlebot3_autorace_camera', 'turtlebot3_autorace_detect',
                  'turtlebot3_autorace_driving', 'turtlebot3_description', 'turtlebot3_gazebo')
    code, output = workspace.manual('autorace')
    assert code == 1
    assert '[run] these packages of ROS are missing: image_proc; install ' in output, output


def test_navigation_needs_a_map(workspace, tmp_path):
    workspace.add('amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
                  'turtlebot3_description', 'turtlebot3_navigation')
    code, output = workspace.manual('navigation', '--dir', tmp_path)
    assert code == 1
    assert 'there is no map {}/map.yaml; make it: ./run manual slam'.format(tmp_path) in output


def test_a_launch_file_that_fails_ends_it_at_once(workspace, tmp_path):
    workspace.add('gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam')
    code, output = workspace.manual('slam', '--dir', tmp_path)
    assert code == 1
    assert '[run] no message on /map before roslaunch has ended; see what ' in output, output


def test_slam_maps_the_world_and_says_how_well(workspace, tmp_path):
    workspace.add('gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam')
    workspace.write('turtlebot3_slam/turtlebot3_slam.launch', LAUNCH)
    workspace.write('gmapping/mapper.py', MAPPER)
    code, output = workspace.manual('slam', '--dir', tmp_path, 'real_time_factor:=3')
    assert code == 0, output
    assert '9 of 9 pillars are in the map' in output, output
    error = re.search(r'frame of the world, .* at most (\S+) m', output)
    assert error and float(error.group(1)) < 0.05, output
    assert (tmp_path / 'map.pgm').exists() and (tmp_path / 'map.yaml').exists()


def test_goals_are_in_the_frame_of_a_map_that_is_turned(workspace, tmp_path):
    workspace.add('amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
                  'turtlebot3_description', 'turtlebot3_navigation')
    workspace.write('turtlebot3_navigation/turtlebot3_navigation.launch',
                    '<launch><arg name="model"/><arg name="map_file"/><arg name="open_rviz"/>'
                    '<node name="navigation" pkg="move_base" type="navigation.py"/></launch>')
    workspace.write('move_base/navigation.py', NAVIGATION)
    (tmp_path / 'map.yaml').write_text('')
    code, output = workspace.manual('navigation', '--dir', tmp_path, '--goal', 1.7, 0.55, 0)
    assert code == 0, output
    line = re.search(r'goal 1.7 0.55: reached after \d+ s, (\S+) m from it in the frame of the '
                     r'map, (\S+) m in the frame of the world', output)
    assert line, output
    # 3.85 m from the start, about which the map is turned
    assert float(line.group(1)) < 0.03 and abs(float(line.group(2)) - 0.269) < 0.03, output
