"""--help of each script: it is printed whole without a master, and nothing is started."""
import os
import subprocess
import sys

import pytest

from img_recog_helpers import expected
from img_recog_helpers.pages import ROOT

NODES = ('usb_cam_node.py', 'color_img_recog.py', 'pybullet_sim.py', 'teleop_key.py',
         'robots.py', 'web.py')
# as from a launch file with args="--help"
OF_ROSLAUNCH = ('__name:=other', 'cmd_vel:=/robot/cmd_vel', '_rate:=1')


@pytest.mark.parametrize('script', sorted(
    name for name in os.listdir(os.path.join(ROOT, 'scripts')) if name.endswith('.py')))
def test_help(script):
    # catkin makes the program that rosrun starts; with two, rosrun asks which one is meant
    assert not os.access(os.path.join(ROOT, 'scripts', script), os.X_OK), 'chmod -x it'
    done = subprocess.run(
        [sys.executable, os.path.join(ROOT, 'scripts', script), '--help',
         *(OF_ROSLAUNCH if script in NODES else ())],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, timeout=60,
        universal_newlines=True,
        env=dict(os.environ, ROS_MASTER_URI='http://127.0.0.1:9', COLUMNS='99'))
    lines = [line for line in done.stderr.splitlines() if 'pybullet build time' not in line]
    assert (done.returncode, lines) == (0, [])
    # as Python names them from 3.10 on
    expected.check_printed('help/{}.txt'.format(script[:-len('.py')]), done.stdout.replace(
        'optional arguments:', 'options:'))
