"""replay.py --camera robot as a user runs it: the loop from vision to motion, without a master."""
import csv
import os
import re
import textwrap

import cv2
import pytest

from img_recog_helpers.pages import ROOT
from img_recog_helpers.replaying import contents
from img_recog_helpers.simulator_tools import burger

FOLLOW = os.path.join(ROOT, 'config', 'follow.yaml')
FILES = ['robot_in_color_posts.replay' + extension for extension in ('.bag', '.csv', '.png')]
TAG = ('<gazebo reference="camera_link"><sensor type="camera" name="eye"><camera><image>'
       '<width>160</width><height>120</height></image></camera>'
       '<plugin name="p" filename="libgazebo_ros_camera.so"><updateRate>10</updateRate>'
       '<frameName>eye_optical</frameName></plugin></sensor></gazebo>')


@pytest.fixture
def replay(ros, tmp_path):
    """A function that runs replay.py --camera robot; there is no master. It returns its line."""
    def run(*arguments):
        process = ros.start_node('replay.py', '--camera', 'robot', '--world', 'color_posts',
                                 *arguments, cwd=str(tmp_path),
                                 env=dict(ros.env, HOME=str(tmp_path), PWD=str(tmp_path)))
        assert process.wait() == 0, process.output
        line, = (line for line in process.output.splitlines()
                 if not line.startswith('pybullet build time'))
        return line
    return run


def rows(folder):
    with open(str(folder / FILES[1])) as file:
        return list(csv.DictReader(file))


def test_the_function_in_the_documentation_drives_in_place_of_the_colors(replay, tmp_path):
    with open(os.path.join(ROOT, 'doc', 'replay.md')) as page:
        code = re.search(r'    import cv2\n(?:(?: {4}.*)?\n)+', page.read()).group()
    (tmp_path / 'follow.py').write_text(textwrap.dedent(code))
    options = ('--seconds', '3', '--no-teleop', '--recognize', 'follow:drive')
    replay(*options)
    assert list(contents(tmp_path)) == FILES
    found = rows(tmp_path)
    assert {row['commands_linear_x_m_per_s'] for row in found} == {'0.15'}
    assert float(found[-1]['x_m']) == pytest.approx(-1.6, abs=0.1)


def test_the_article_colors_drive_to_blue(replay, tmp_path, ros):
    line = replay('--seconds', '6')
    found = rows(tmp_path)
    blue = [int(row['blue_px']) for row in found]
    seen = next(number for number, area in enumerate(blue) if area <= 1000)
    assert seen > 60 and max(blue) > 4 * blue[0] > 4000 and blue[-1] == 0
    assert {row['commands_linear_x_m_per_s'] for row in found[:seen]} == {'10.0'}
    assert {row['commands_linear_x_m_per_s'] for row in found[seen:]} == {''}
    assert float(found[0]['x_m']) == -2.0 and -0.4 < float(found[seen]['x_m']) < 0.3
    assert float(found[-1]['linear_x_m_per_s']) == pytest.approx(0.0, abs=0.01)
    assert 'ends at x {:.3f} m'.format(float(found[-1]['x_m'])) in line
    assert cv2.imread(str(tmp_path / FILES[2])).shape == (900, 1400, 3)
    info = ros.run('rosbag', 'info', str(tmp_path / FILES[0]))
    assert re.search(r'color_detection +182 msgs', info), info


def test_the_camera_of_a_tag_is_used(replay, tmp_path):
    (tmp_path / 'robot.urdf').write_text(burger(TAG))
    line = replay('--seconds', '2', '--colors', FOLLOW, '--urdf', 'robot.urdf')
    assert line.startswith('20 frames, 2.000 s simulated in ')
    found = rows(tmp_path)
    assert max(int(row['ahead_px']) for row in found) < 19200
    assert {row['search_px'] for row in found} == {'19200'}
