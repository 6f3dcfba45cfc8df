"""replay.py as a user runs it: without a master, from any working directory."""
import csv
import os
import re
import subprocess

import cv2
import numpy as np
import pytest
import rosbag
import rospy
from std_msgs.msg import Header

from img_recog.conversions import image_msgs
from img_recog.formats import world_file
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.simulation_settings import PhysicsSettings, RobotSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.simulated_model import Robot
from img_recog_helpers.parsed import lumped
from img_recog_helpers.pages import ROOT
from img_recog_helpers.replaying import contents
from img_recog_helpers.robots import burgers_drive
from img_recog_helpers.simulator_tools import burger
from img_recog_helpers.videos import opencv_frames
from img_recog_helpers.waiting import wait_for

VIDEO = os.path.join(ROOT, 'test', 'data', 'bikes.mp4')
WORLD = os.path.join(ROOT, 'urdf', 'turtlebot3_world.urdf')
RANGES = (((50, 100, 100), (150, 255, 255)), ((150, 100, 150), (180, 255, 255)))
SECONDS = 4.6       # of the video: a blue bike, and then a red one
FILES = ['bikes.replay.bag', 'bikes.replay.csv', 'bikes.replay.png']


@pytest.fixture
def replay(ros, tmp_path):
    """A function that runs replay.py in a folder; there is no master."""
    def run(*arguments, cwd=tmp_path):
        process = ros.start_node('replay.py', *arguments, cwd=str(cwd),
                                 env=dict(ros.env, HOME=str(tmp_path), PWD=str(cwd)))
        code = process.wait()
        lines = [line for line in process.output.splitlines()
                 if not line.startswith('pybullet build time')]
        return code, lines
    return run


def video_areas(path):
    """Return blue and red area of each frame of a video, computed with OpenCV only."""
    return [[cv2.countNonZero(cv2.inRange(cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV),
                                          *map(np.array, bounds))) for bounds in RANGES]
            for rgb in opencv_frames(path)]


def drive(areas):
    """Return the pose of the demo's robot at the end of a video of these areas, 25 Hz."""
    client = connect()
    world = World(PhysicsSettings(), world_file.read(WORLD, {}), client)
    robot = Robot(ConfiguredModel('burger', lumped(burger()), RobotSettings(
        drive=burgers_drive())), world)
    world.add([robot])
    simulator = Simulator(world)
    for step in range(0, 40 * len(areas), 20):
        if step % 100 == 0:
            robot.command(0.0, 0.0)
        if step % 40 == 0:
            for area, speed in zip(areas[step // 40], (10.0, -10.0)):
                if area > 1000:
                    robot.command(speed, 0.0)
        simulator.advance(20)
    return robot.body.motion()


def write_bag(path, images):
    """Write a bag with rgb8 images, 25 Hz."""
    with rosbag.Bag(path, 'w') as bag:
        for number, image in enumerate(images):
            stamp = rospy.Time(100 + number // 25, number % 25 * 40000000)
            bag.write('/usb_cam/image_raw',
                      image_msgs.to_msg(image, 'rgb8', Header(number, stamp, 'eye')), stamp)


def test_video(replay, tmp_path, ros):
    """Two runs write the same bytes; areas and final pose equal separately computed ones.

    A bag with the images of the video gives the same table.
    """
    (tmp_path / 'films').mkdir()
    film = str(tmp_path / 'films' / 'bikes.mp4')
    subprocess.run(['ffmpeg', '-v', 'error', '-i', VIDEO, '-t', str(SECONDS), '-c', 'copy', film],
                   check=True)
    code, lines = replay(film)
    assert code == 0 and len(lines) == 1, lines
    first = contents(tmp_path)
    assert list(first) == FILES
    code, again = replay(film)
    assert code == 0 and contents(tmp_path) == first
    assert [name for name in os.listdir(str(tmp_path)) if name.startswith('.bikes')] == []

    areas = video_areas(film)
    assert len(areas) > 25 * SECONDS - 1
    # both colors move the robot
    assert all(max(each) > 1000 for each in zip(*areas))
    rows = list(csv.DictReader(first['bikes.replay.csv'].decode().splitlines()))
    assert [[int(row['blue_px']), int(row['red_px'])] for row in rows] == areas
    assert [row['time_s'] for row in rows[:3]] == ['0.000000000', '0.040000000', '0.080000000']
    found = re.match(r'(\d+) frames, (\S+) s simulated in .* times real time .*ends at x (\S+) m, '
                     r'y (\S+) m, .*; wrote (.*)$', lines[0])
    end = drive(areas).position
    assert found.groups() == (
        str(len(areas)), *map('{:.3f}'.format, (len(areas) / 25, end[0], end[1])),
        ', '.join(FILES))
    assert cv2.imread(str(tmp_path / 'bikes.replay.png')).shape == (900, 1400, 3)

    info = ros.run('rosbag', 'info', str(tmp_path / 'bikes.replay.bag'))
    for topic, kind in (('cmd_vel', 'geometry_msgs/Twist'), ('odom', 'nav_msgs/Odometry'),
                        ('color_detection', 'sensor_msgs/PointCloud'),
                        ('joint_states', 'sensor_msgs/JointState'), ('tf', 'tf2_msgs/TFMessage')):
        assert re.search(r'/{} +\d+ msgs +: {}'.format(topic, kind), info), info

    write_bag(str(tmp_path / 'bikes.bag'), opencv_frames(film))
    assert replay('~/bikes.bag', '--output', '~/of_bag')[0] == 0
    tables = [[row[:2] + row[3:] for row in csv.reader(text.splitlines())] for text in (
        first['bikes.replay.csv'].decode(), (tmp_path / 'of_bag.csv').read_text())]
    assert tables[0] == tables[1]


def test_interrupted_replay_leaves_no_files(ros, tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / 'long.avi'), cv2.CAP_FFMPEG,
                             cv2.VideoWriter_fourcc(*'MJPG'), 2.0, (64, 48))
    for _ in range(5000):
        writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    process = ros.start_node('replay.py', 'long.avi', cwd=str(tmp_path))
    wait_for(lambda: [name for name in os.listdir(str(tmp_path))
                      if '.csv.' in name and name.endswith('.img_recog')],
             lambda: 'files to write to in ' + process.output)
    assert process.interrupt() == 130, process.output
    assert 'Traceback' not in process.output, process.output
    assert [name for name in os.listdir(str(tmp_path)) if 'long' in name] == ['long.avi']


def test_what_is_refused_is_one_line(replay, tmp_path):
    before = sorted(os.listdir(str(tmp_path)))
    code, lines = replay('no.mp4')
    assert code == 1 and lines == [
        'replay.py: error: cannot read no.mp4: no such file; give a video that FFmpeg plays, a '
        'folder of images, or a bag with images']
    left = set(os.listdir(str(tmp_path))) - {'ros', '.config', '.cache'}
    assert left == set(before) - {'ros'}, 'nothing is left behind'
