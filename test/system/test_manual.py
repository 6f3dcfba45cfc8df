"""./run manual: what is missing is one line; the whole of slam, with a mapper of this test."""
import os
import re
import subprocess

import pytest

from img_recog_testing.pages import ROOT

PACKAGE = """<package format="2">
  <name>{}</name><version>1.0.0</version><description>-</description><license>-</license>
  <maintainer email="nobody@example.com">nobody</maintainer>
</package>"""
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


def manual(env, *words):
    done = subprocess.run(['./run', 'manual', *map(str, words)], cwd=ROOT, env=env, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600)
    return done.returncode, done.stdout.decode(errors='replace')


@pytest.fixture
def env(ros, tmp_path):
    """Of a shell that sees, beside this package, only the packages in a folder of the test."""
    return dict(ros.env, ROS_PACKAGE_PATH=str(tmp_path / 'packages'))


def add(tmp_path, *names):
    for name in names:
        (tmp_path / 'packages' / name).mkdir(parents=True)
        (tmp_path / 'packages' / name / 'package.xml').write_text(PACKAGE.format(name))


def test_packages_that_are_missing_are_named_in_one_line(env, tmp_path):
    add(tmp_path, 'gmapping', 'turtlebot3_slam')
    code, output = manual(env, 'slam', '--dir', tmp_path)
    assert code == 1
    line, = [line for line in output.splitlines() if 'missing' in line]
    assert line.startswith('[run] these packages of ROS are missing: turtlebot3_bringup '
                           'turtlebot3_description; ')


def test_navigation_needs_a_map(env, tmp_path):
    add(tmp_path, 'amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
        'turtlebot3_description', 'turtlebot3_navigation')
    code, output = manual(env, 'navigation', '--dir', tmp_path)
    assert code == 1
    assert 'there is no map {}/map.yaml; make it: ./run manual slam'.format(tmp_path) in output


def test_a_launch_file_that_fails_ends_it_at_once(env, tmp_path):
    add(tmp_path, 'gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam')
    code, output = manual(env, 'slam', '--dir', tmp_path, 'web:=false', 'gui:=false')
    assert code == 1
    assert '[run] no message on /map before roslaunch has ended; see what ' in output, output


def test_slam_maps_the_world_and_says_how_well(env, tmp_path):
    add(tmp_path, 'gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam')
    packages = tmp_path / 'packages'
    (packages / 'turtlebot3_slam' / 'turtlebot3_slam.launch').write_text(LAUNCH)
    mapper = packages / 'gmapping' / 'mapper.py'
    mapper.write_text(MAPPER.format(python=os.path.join(ROOT, '.venv', 'bin', 'python3')))
    mapper.chmod(0o755)
    code, output = manual(env, 'slam', '--dir', tmp_path, 'web:=false', 'gui:=false',
                          'real_time_factor:=3')
    assert code == 0, output
    assert '9 of 9 pillars are in the map' in output, output
    error = re.search(r'frame of the world, .* at most (\S+) m', output)
    assert error and float(error.group(1)) < 0.05, output
    assert (tmp_path / 'map.pgm').exists() and (tmp_path / 'map.yaml').exists()
