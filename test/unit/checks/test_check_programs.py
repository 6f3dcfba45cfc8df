"""What check_robot.py, check_world.py and simulate.py print, and their exit codes."""
import json
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

from img_recog.checks import check_jobs
from img_recog_helpers.pages import ROOT
from img_recog_helpers.robots import burger
from img_recog_helpers.sdf import BOX, BUILT_IN, sdf

WALL = ('<model name="wall"><static>1</static><link name="l">'
        + BOX.format('visual', '', '0.1 4 2') + '</link></model>')
BALL = ('<model name="ball"><pose>3 0 10 0 0 0</pose><link name="l"><inertial><mass>2</mass>'
        '<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link></model>')
DOOR = ('<model name="door"><link name="post"/><link name="l"><pose>0.5 0 1 0 0 0</pose></link>'
        '<joint name="to_world" type="fixed"><parent>world</parent><child>post</child></joint>'
        '<joint name="hinge" type="revolute"><parent>post</parent><child>l</child><pose>-0.5 0 0 '
        '0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></model>')
EYE = ('<gazebo reference="camera_link"><sensor type="camera" name="eye"><camera><image>'
       '<width>64</width><height>48</height></image></camera><plugin name="p" '
       'filename="libgazebo_ros_camera.so"><cameraName>front</cameraName></plugin></sensor>'
       '</gazebo>')
EYES = ('<model name="eyes"><static>1</static><link name="l">{}</link></model>'.format(''.join(
    '<sensor name="{}" type="{}">{}</sensor>'.format(*each) for each in (
        ('scan', 'ray', ''), ('around', 'gpu_ray', '<ray><scan><horizontal><samples>1</samples>'
                              '</horizontal></scan></ray>'), ('tilt', 'imu', ''),
        ('cam', 'camera', '<camera><image><width>32</width><height>24</height></image><noise>'
                          '<stddev>0.1</stddev></noise></camera>')
    ))))
WHEELS = ('<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>'
          'wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint></plugin>'
          '</gazebo>')
CHAIR = '<include><uri>model://chair</uri></include>'


@pytest.fixture
def run(tmp_path, monkeypatch, capsys, caplog, handlers_as_before):
    """A function that runs a program in a folder; it returns the exit code and the lines."""
    monkeypatch.chdir(tmp_path)

    def start(program, *words):
        caplog.clear()
        monkeypatch.setattr(sys, 'argv', [program, *words])
        code = check_jobs.main(program)
        log = ['{}: {}: {}'.format(program, record.levelname.lower(), record.getMessage())
               for record in caplog.records]
        return code, [*filter(None, ''.join(capsys.readouterr()).splitlines()), *log]
    return start


@pytest.mark.parametrize('program, text, code, line', [
    ('check_robot.py', burger(WHEELS), 0, 'robot turtlebot3_burger in my.file'),
    ('check_robot.py', burger(''), 2, 'warning: my.file: it does not drive, as it has no drive'),
    ('check_robot.py', '<robot name="r"><link name="a"/></robot>', 1,
     'check_robot.py: error: cannot use the robot in my.file: link a can move but has no mass; '
     'add an <inertial> to it or to a link fixed to it'),
    ('check_world.py', sdf(BUILT_IN, WALL), 0, 'world my in my.file'),
    ('check_world.py', sdf(BUILT_IN, WALL.replace('<visual', '<projector/><visual')), 2,
     'warning: world my.file: not simulated: <projector> of model wall link l'),
    ('check_world.py', sdf(BUILT_IN, WALL, CHAIR), 1, 'check_world.py: error: something is left '
     'out of it; give --allow-partial-world here, and allow_partial_world:=true to the demo'),
    ('check_world.py --allow-partial-world', sdf(BUILT_IN, WALL, CHAIR), 2,
     'warning: world my.file: loaded without: model://chair')])
def test_the_exit_code_says_whether_it_can_be_used(run, tmp_path, program, text, code, line):
    """All that is printed is in test/expected/check_robot and check_world."""
    (tmp_path / 'my.file').write_text(text)
    found, lines = run(*program.split(), 'my.file')
    assert found == code and [each for each in lines if each.startswith(line)], lines
    assert code != 1 or len([each for each in lines if 'error' in each]) == 1


SENSOR = '<sensor name="s" type="{}">{}</sensor>'
DRIVE = ('<plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>a</leftJoint>'
         '<rightJoint>b</rightJoint></plugin>')


@pytest.mark.parametrize('inside, line', [
    (SENSOR.format('gps', ''), 'model wall: not simulated: sensor gps'),
    (SENSOR.format('ray', '<ray><scan><horizontal><samples>x</samples></horizontal></scan></ray>'
                   '<plugin name="p" filename="libgazebo_ros_laser.so"/>'),
     'model wall: not simulated: its sensors; cannot use the robot in model wall: '
     "<ray/scan/horizontal/samples> of sensor s: got 'x', expected a whole number"),
    (SENSOR.format('camera', '<camera><horizontal_fov>wide</horizontal_fov></camera><plugin '
                   'name="p" filename="libgazebo_ros_camera.so"/>'),
     'model wall: not simulated: its sensors; cannot use the robot in model wall: '
     "<horizontal_fov> of sensor s: got 'wide', expected a finite number"),
    (DRIVE, 'model wall: not simulated: its sensors and its drive; cannot use the robot in model '
     'wall: the robot has no movable joint a (movable joints: none); set left_joint to the joint '
     'of a wheel; one that moves nothing with an <inertial> is left out')])
def test_a_world_gets_the_same_warnings_from_both_programs(run, tmp_path, inside, line):
    text = WALL.replace('</link>', inside + '</link>') if '<sensor' in inside else WALL.replace(
        '</model>', inside + '</model>')
    (tmp_path / 'my.sdf').write_text(sdf(BUILT_IN, text))
    for words in (('check_world.py',), ('simulate.py', '--until', '0.01')):
        code, lines = run(*words, 'my.sdf')
        assert code == 2 and 'warning: ' + line in lines, lines


@pytest.mark.parametrize('program, file', [('check_robot.py', 'turtlebot3_burger.urdf'),
                                           ('check_world.py', 'color_posts.sdf')])
def test_our_own_robot_and_world_can_be_used(run, program, file):
    code, lines = run(program, os.path.join(ROOT, 'urdf', file))
    assert code == 0 and not [line for line in lines if line.startswith('warning')], lines


def test_a_world_as_figures(run, tmp_path):
    (tmp_path / 'fall.sdf').write_text(sdf(BUILT_IN, BALL))
    (tmp_path / 'my.urdf').write_text(burger())
    command = ('simulate.py', 'fall.sdf', '--urdf', 'my.urdf', '--twist', '0.2,0', '--until', '1',
               '--every', '0.5', '--velocity', 'ball=0.5,0,0')
    code, lines = run(*command)
    assert code == 0, lines
    assert run(*command) == (0, lines)
    begin, half, end, *sensors, masses = map(json.loads, lines)
    assert [line['t'] for line in (begin, half, end)] == [0, 0.5, 1]
    assert begin['links']['ball::l'] == pytest.approx(
        [3, 0, 10, 0, 0, 0, 1] + [0.5, 0, 0] + [0] * 3)
    # sums over steps of 1 ms, of which each falls at the velocity of its end
    assert end['links']['ball::l'][:3] == pytest.approx([3.5, 0, 5.0951], abs=1e-4)
    assert 0.1 < end['links']['turtlebot3_burger::base_footprint'][0] < 0.2
    assert 'turtlebot3_burger::base_scan' not in end['links']       # lumped, like in Gazebo
    assert end['joints']['turtlebot3_burger::wheel_left_joint'][1] == pytest.approx(6.06, abs=0.1)
    assert [line.get('imu') or line['ray'] for line in sensors] == ['imu', 'scan']
    assert len(sensors[1]['ranges']) == 360
    assert masses['mass']['ball::l'] == pytest.approx([2, 1, 1, 1])


def test_pictures_of_the_cameras_of_a_robot(run, tmp_path):
    (tmp_path / 'my.urdf').write_text(burger().replace('</robot>', EYE + '</robot>'))
    code, lines = run('simulate.py', 'color_posts', '--urdf', 'my.urdf', '--until', '0.01',
                      '--pictures', 'eyes')
    assert code == 0, lines
    image = cv2.imread(str(tmp_path / 'eyes' / 'eye.png'))
    assert image.shape == (48, 64, 3)
    assert image.std() > 5          # something is seen


def test_sensors_of_models_are_printed_and_drawn_by_their_names(run, tmp_path):
    (tmp_path / 'eyes.sdf').write_text(sdf(BUILT_IN, WALL, EYES))
    code, lines = run('simulate.py', 'eyes.sdf', '--until', '0.01', '--pictures', '.')
    assert code == 0, lines
    tilt, scan, around = map(json.loads, lines[-4:-1])
    assert list(scan) == ['ray', 'ranges'] and scan['ray'] == 'scan'
    assert around['gpuray'] == 'around' and len(around['ranges']) == 1
    assert tilt == {'imu': 'tilt', 'acc': pytest.approx([0, 0, 9.8]), 'gyro': [0, 0, 0]}
    image = cv2.imread(str(tmp_path / 'cam.png'))
    # the camera is in the wall and sees grey, with noise
    assert image.shape == (24, 32, 3) and (image == image[..., :1]).all() and image.std() > 5


def test_bullet_prints_nothing_between_the_lines_of_json(tmp_path):
    """It has a warning for each ray that meets a heightmap."""
    cv2.imwrite(str(tmp_path / 'a.png'), np.full((5, 5), 99, np.uint8))
    hills = ('<model name="h"><static>1</static><link name="l"><collision name="c"><geometry>'
             '<heightmap><uri>a.png</uri><size>9 9 1</size></heightmap></geometry></collision>'
             '</link></model>')
    (tmp_path / 'hills.sdf').write_text(sdf(BUILT_IN, hills, EYES))
    done = subprocess.run(
        [sys.executable, '-c', 'from img_recog.checks import check_jobs\n'
         'raise SystemExit(check_jobs.main("simulate.py"))', 'hills.sdf', '--until', '0.01'],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=str(tmp_path))
    assert done.returncode == 0 and b'b3Warning' in done.stderr, done
    assert json.loads(done.stdout.splitlines()[-1])['end']
    assert all(map(json.loads, done.stdout.splitlines()))


def test_what_cannot_be_drawn_is_said(run, tmp_path):
    (tmp_path / 'bad.stl').write_text('solid bad')
    (tmp_path / 'eyes.sdf').write_text(sdf(BUILT_IN, WALL, EYES).replace(
        '</link>', '<visual name="bad"><geometry><mesh><uri>bad.stl</uri></mesh></geometry>'
        '</visual></link>', 1))
    code, lines = run('simulate.py', 'eyes.sdf', '--until', '0.01', '--pictures', '.')
    assert code == 2
    assert any(line.startswith('warning: world eyes: not drawn: cannot read the mesh')
               for line in lines)


def test_a_motor_drives_a_joint(run, tmp_path):
    (tmp_path / 'door.sdf').write_text(sdf(BUILT_IN, DOOR))
    code, lines = run('simulate.py', 'door.sdf', '--until', '0.5', '--every', '0.5',
                      '--drive', 'door::hinge=1:1000')
    assert code == 0, lines
    assert json.loads(lines[1])['joints']['door::hinge'] == pytest.approx([0.5, 1], abs=0.01)


@pytest.mark.parametrize('options, words', [
    (['--drive', 'door::hing=1:5'],
     'no movable joint door::hing (movable joints: door::hinge)'),
    (['--twist', '1,0'], '--twist: there is no robot; set --urdf, or '
     'give a model of the world the plugin of a drive'),
    (['--velocity', 'dor=1,2,3'], "no model 'dor' (models: ground_plane, door)")])
def test_wrong_options_of_simulate(run, tmp_path, options, words):
    (tmp_path / 'door.sdf').write_text(sdf(BUILT_IN, DOOR))
    assert run('simulate.py', 'door.sdf', *options) == (1, ['simulate.py: error: ' + words])


def test_what_is_left_out_of_a_world_as_figures(run, tmp_path):
    (tmp_path / 'part.sdf').write_text(sdf(BUILT_IN, WALL, CHAIR))
    code, lines = run('simulate.py', 'part.sdf', '--until', '0.001')
    assert code == 2
    assert ('warning: world part.sdf: loaded without: model://chair; set GAZEBO_MODEL_PATH to the '
            'folders of the models') in lines
