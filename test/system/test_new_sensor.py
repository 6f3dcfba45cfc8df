"""A sensor is added by three edits: made in a copy of the tree, for a sonar that is not in it."""
import math
import os
import shutil
import subprocess
import sys

import pytest

from img_recog_helpers.pages import ROOT
from img_recog_helpers.simulator_tools import Messages, burger, complaints

PARTS = ('src', 'doc', 'launch', 'scripts', 'test', 'tools', 'CONTRIBUTING.md', 'README.md',
         'README.ja.md', 'run')

SENSOR = '''"""A sonar: one ray."""
from dataclasses import dataclass

import numpy as np

from img_recog.formats.gazebo_tags import NAME, NUMBER, RATE, Row, Tags
from img_recog.settings import Settings, above, not_empty, setting
from img_recog.simulation.sensors.ray_sensor import RaySensor
from img_recog.simulation.sensors.sensor import Mount

TAGS = Tags(('gazebo_ros_range',), (
    Row('sonar_period_s', RATE, 'plugin', 'updateRate'),
    Row('sonar_range_max', NUMBER, 'sensor', 'ray/range/max'),
    Row('sonar_topic', NAME, 'plugin', 'topicName')),
    sensors=('ray', 'sonar'), frame='sonar_frame', needs_sensor=True)


@dataclass(frozen=True)
class SonarSettings(Settings):
    """A ray along x of `sonar_frame`; m."""

    sonar_frame: str = setting('base_scan', not_empty())
    sonar_period_s: float = setting(0.05, above(0))
    sonar_range_max: float = setting(4.0, above(0))
    sonar_topic: str = setting('sonar', not_empty())


class Sonar(RaySensor):
    """Measures one distance."""

    def __init__(self, mount: Mount, settings: SonarSettings):
        mount.robot.check_frame('sonar_frame', settings.sonar_frame)
        super().__init__(mount, settings.sonar_frame, np.array([[1.0], [0.0], [0.0]]),
                         (0.2, settings.sonar_range_max))

    def measure(self, distances: np.ndarray) -> float:
        return float(distances[0])
'''

CONVERSIONS = '''"""Converts sensor_msgs/Range."""
from sensor_msgs.msg import Range


def to_msg(distance, settings, stamp, out=None):
    """Return the message for a distance in m."""
    msg = out or Range(max_range=settings.sonar_range_max)
    msg.header.frame_id, msg.header.stamp, msg.range = settings.sonar_frame, stamp, distance
    return msg


def from_msg(msg):
    """Return the distance in a message in m."""
    return msg.range
'''

IMPORTS = '''from img_recog.conversions import sonar_msgs
from img_recog.simulation.sensors import sonar
from sensor_msgs.msg import Range
'''
ROW = '''    SensorKind('sonar', sonar.SonarSettings, sonar.Sonar, sonar.TAGS, Range,
               sonar_msgs.to_msg, noise_number=4),
'''
TAG = '''<gazebo reference="imu_link"><sensor type="ray" name="ear">
  <ray><range><min>0.2</min><max>3</max></range></ray>
  <plugin name="ear" filename="libgazebo_ros_range.so"><topicName>ear</topicName></plugin>
  </sensor></gazebo>'''


@pytest.fixture(scope='module')
def tree(tmp_path_factory):
    """A copy of the tree with a sonar."""
    copy = tmp_path_factory.mktemp('copy')
    for part in PARTS:
        path = os.path.join(ROOT, part)
        if os.path.isdir(path):
            # with what is compiled: its times are those of the files
            shutil.copytree(path, str(copy / part))
        else:
            shutil.copy(path, str(copy / part))
    package = copy / 'src' / 'img_recog'
    (package / 'simulation' / 'sensors' / 'sonar.py').write_text(SENSOR)
    (package / 'conversions' / 'sonar_msgs.py').write_text(CONVERSIONS)
    table = package / 'conversions' / 'sensor_table.py'
    head, end, row = 'from img_recog', '\n)\n', table.read_text()
    assert row.count(end) == 1
    row = row.replace(end, '\n' + ROW + ')\n')
    table.write_text(row.replace(head, IMPORTS + head, 1))
    return copy


def env_of(ros, tree):
    paths = [str(tree / 'src'), str(tree / 'test'), ros.env['PYTHONPATH']]
    env = dict(ros.env, PYTHONPATH=os.pathsep.join(paths))
    env.pop('IMG_RECOG_ACCEPT', None)  # the pages without the sonar are the right ones
    return env


def test_its_topic_is_published_by_default_and_by_tags(ros, tree):
    ros.start_master()
    ros.set_parameters('/gazebo/robots', {'a': {'x_pos': -2.0, 'y_pos': 0.0},
                                          'b': {'x_pos': 2.0, 'y_pos': 0.0, 'yaw': math.pi}})
    ros.set_parameters('/robot_description', burger())
    ros.set_parameters('/b/robot_description', burger(TAG))
    node = ros.start(sys.executable, str(tree / 'scripts' / 'pybullet_sim.py'),
                     '__name:=gazebo', '_several_robots:=true', env=env_of(ros, tree))
    node.wait_output('simulating 2 robots')
    for topic, frame in (('/a/sonar', 'a/base_scan'), ('/b/ear', 'b/imu_link')):
        seen = Messages(ros, topic).wait_more(3)
        # posts of radius 0.15 m at x -1.1 and 1.1; both links are 0.032 m behind the robot's root
        assert [msg.range for msg in seen[:3]] == pytest.approx(
            [2.0 + 0.032 - 1.1 - 0.15] * 3, abs=0.01)
        assert {msg.header.frame_id for msg in seen} == {frame}
    assert node.interrupt() == 0, node.output
    assert 'Traceback' not in node.output
    assert complaints(node) == []


def test_it_breaks_no_wall_and_is_missing_in_the_documentation(ros, tree):
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-k',
         'test_walls or topics and gazebo or up_to_date and reference',
         'test/system/test_documentation.py', 'test/unit/test_walls.py'],
        cwd=str(tree), env=env_of(ros, tree), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        check=False)
    lines = done.stdout.decode()
    assert done.returncode == 1, lines
    assert 'missing: sonar (sensor_msgs/Range)' in lines
    assert '+| `sonar_range_max` | `4.0` | a finite number above 0 | |' in lines
    assert '2 failed' in lines
