"""--help of each script: it is printed without a master, and nothing is started."""
import functools
import os
import re
import subprocess
import sys

import pytest

from img_recog_helpers.pages import ROOT, read, rows

REFERENCE = read('doc/reference.md')
# of each node: its chapter, and topics and services of its docstring
NODES = {
    'usb_cam_node.py': ('usb_cam', ('~camera_info (sensor_msgs/CameraInfo)', '~start_capture')),
    'color_img_recog.py': ('color_extract', ('usb_cam/image_raw', 'cmd_vel (geometry_msgs/Twist')),
    'pybullet_sim.py': ('gazebo', ('cmd_vel (geometry_msgs/Twist', '/clock', '~reset_world')),
    'teleop_key.py': ('turtlebot3_teleop_keyboard', ('cmd_vel (geometry_msgs/Twist)', '~yield')),
    'republish.py': ('image_republisher', ('in/compressed (sensor_msgs/CompressedImage)',)),
    'robots.py': ('robots', ('~reload (std_srvs/Trigger)',)),
    'web.py': ('web', ('gazebo/set_pose (geometry_msgs/PoseStamped', 'odom (nav_msgs/Odometry)'))}
# parameters that are in no settings class; their docstrings name them
OTHERS = ('intrinsic_controls', 'colors', 'blue_image_topic', 'red_image_topic')


@functools.lru_cache(maxsize=None)
def help_of(script, *arguments):
    """Return what the script prints; no master answers there."""
    done = subprocess.run(
        [sys.executable, os.path.join(ROOT, 'scripts', script), *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, timeout=60,
        universal_newlines=True, env=dict(os.environ, ROS_MASTER_URI='http://127.0.0.1:9'))
    lines = [line for line in done.stderr.splitlines() if 'pybullet build time' not in line]
    assert (done.returncode, lines) == (0, [])
    return done.stdout


@pytest.mark.parametrize('script', sorted(
    {name for name in os.listdir(os.path.join(ROOT, 'scripts')) if name.endswith('.py')}
    - set(NODES)))
def test_program_prints_its_usage(script):
    assert re.search(r'^usage: {} '.format(re.escape(script)), help_of(script, '--help'), re.M)


@pytest.mark.parametrize('script', (
    'check_robot.py', 'check_world.py', 'doctor.py', 'evaluate.py', 'film.py', 'fit_colors.py',
    'graph.py', 'plot.py', 'replay.py', 'simulate.py', 'sweep.py'))
def test_options_agree_with_the_script(script):
    options = sorted(set(re.findall(r'(?<!\S)--[a-z-]+', help_of(script, '--help'))) - {'--help'})
    assert sorted(row[0].strip('`') for row in rows(REFERENCE, script, 'option')) == options


@pytest.mark.parametrize('script', sorted(NODES))
def test_node_prints_its_topics_and_parameters(script):
    chapter, words = NODES[script]
    # as from a launch file with args="--help"
    printed = help_of(script, '--help', '__name:=other', 'cmd_vel:=/robot/cmd_vel', '_rate:=1')
    assert printed.startswith('usage: rosrun img_recog {} '.format(script))
    assert [word for word in words if word not in printed] == []
    missing = [row[0] for row in rows(REFERENCE, chapter, 'name')
               if row[0].strip('`') not in OTHERS and not re.search(
                   r'^  ~\S*\b{}: {} \({}\)$'.format(*(
                       re.escape(cell.strip('`')) for cell in row[:3])), printed, re.M)]
    assert missing == []
