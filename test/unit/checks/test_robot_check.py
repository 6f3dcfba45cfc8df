"""What is said of robots: given, measured or assumed, and how fast they drive."""
import math

import pytest

from img_recog.checks import robot_check
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger
from img_recog_helpers.wheeled import plugin, robot

DRIVE = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>
  <wheelSeparation>0.16</wheelSeparation><wheelDiameter>0.066</wheelDiameter>
  <commandTopic>go</commandTopic><updateRate>20</updateRate></plugin></gazebo>'''
WHEELS = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint></plugin>
  </gazebo>'''
SKID = plugin('gazebo_ros_skid_steer_drive', leftFrontJoint='left_0_joint', torque=20,
              leftRearJoint='left_1_joint', rightFrontJoint='right_0_joint',
              rightRearJoint='right_1_joint', robotBaseFrame='base_link')
LAMP = '<gazebo><plugin name="lamp" filename="liblamp.so"/></gazebo>'
CAMERA = '''<gazebo reference="camera_link"><sensor type="camera" name="front">
  <update_rate>10</update_rate><camera><image><width>320</width><height>240</height></image>
  </camera>
  <plugin name="p" filename="libgazebo_ros_camera.so"><cameraName>eye</cameraName></plugin>
  </sensor></gazebo>'''
MESH = ('<link name="cover"><visual><geometry><mesh filename="package://lost/x.stl"/></geometry>'
        '</visual></link><joint name="cover_joint" type="fixed"><parent link="base_link"/>'
        '<child link="cover"/></joint>')


@pytest.fixture
def check(tmp_path):
    """A function that checks the burger with more tags, and with texts replaced."""
    def run(tags='', *replaced, **options):
        text = burger('').replace('</robot>', tags + '</robot>')
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / 'robot.urdf'
        path.write_text(text)
        return robot_check.check(str(path), **options)
    return run


ROLLED = 'rpy="-1.57 0 0"/>\n    <axis xyz="0 0 1"/>'
CONTROL = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>'
CONTROLLERS = ('base: {type: diff_drive_controller/DiffDriveController, left_wheel: '
               'wheel_left_joint,\n  right_wheel: [wheel_right_joint]}\narm: {type: arm/Arm}\n')
UNIT = ('<gazebo><plugin name="i" filename="libgazebo_ros_imu.so"><frameName>torso</frameName>'
        '</plugin></gazebo>')
# more tags of the burger, and texts that are replaced in it
CASES = {
    'no drive': (CAMERA,),
    'plugin that is not known': (LAMP + CAMERA,),
    'all in tags': (DRIVE + CAMERA, ('<mu1>0.1</mu1>', '<mu1>0.8</mu1>'),
                    ('<wheelDiameter>0.066</wheelDiameter>',
                     '<wheelDiameter>0.132</wheelDiameter>')),
    'a fixed link and no links': (
        '<gazebo reference="base_link"><mu1>0.3</mu1></gazebo><gazebo reference="wheel"><mu1>1'
        '</mu1></gazebo>' + UNIT,),
    'not simulated': (WHEELS + LAMP + MESH + UNIT,),
    'impossible inertia': (WHEELS, ('ixx="1.1175580e-5"', 'ixx="1"')),
    'planar': (DRIVE.replace('diff_drive', 'planar_move'),),
    'wheels in the air': (WHEELS, ('0.08 0.023', '0.08 0.06'), ('-0.080 0.023', '-0.080 0.06')),
    'wheels backward': (WHEELS, (ROLLED, 'rpy="-1.57 0 0"/><axis xyz="0 0 -1"/>'))}


@pytest.mark.parametrize('name', CASES)
def test_what_is_said_of_a_robot(check, tmp_path, name):
    report = check(*CASES[name])
    text = report.text().replace(str(tmp_path) + '/', '')
    if report.is_partial:
        text += 'something is not done\n'
    expected.check_printed('check_robot/{}.txt'.format(name.replace(' ', '_')), text)


def test_all_of_the_whole_burger_is_in_its_tags(tmp_path):
    path = tmp_path / 'robot.urdf'
    path.write_text(burger())
    report = robot_check.check(str(path))
    assert not report.is_partial
    expected.check_printed('check_robot/burger.txt',
                           report.text().replace(str(tmp_path) + '/', ''))


@pytest.mark.parametrize('axis', ['rpy="-1.57 0 0"/>', '/><axis xyz="0 0 1"/>',
                                  '/><axis xyz="0 1 0"/>'],
                         ids=['no axis', 'axis z', 'flat wheels'])
def test_a_robot_that_does_not_drive_as_asked_is_measured(check, axis):
    report = check(WHEELS, (ROLLED, axis))
    straight, = [row.value for row in report.rows if row.what == 'straight']
    assert report.is_partial
    for words in ('the wheel of wheel_left_joint does not roll forward',
                  'it does not drive as asked: straight {}, asked 0.2; see'.format(straight)):
        assert any(words in line for line in report.warnings), report.warnings


def test_a_robot_that_moves_while_it_turns_is_named(check):
    slippery = ('"wheel_left_link">\n    <mu1>0.1</mu1>\n    <mu2>0.1',
                '"wheel_left_link">\n    <mu1>0.001</mu1>\n    <mu2>0.001')
    report = check(WHEELS, slippery)
    row, = [row for row in report.rows if row.what == 'moved while turning']
    assert row.source == 'asked 0 m'
    assert any('it does not drive as asked: moved while turning ' in line
               for line in report.warnings), report.warnings


@pytest.mark.parametrize('roll, drifts', [('1.57', True), ('1.5707963', False)])
def test_a_skid_steered_robot_is_also_turned_at_a_heading_between_the_axes(tmp_path, roll, drifts):
    path = tmp_path / 'robot.urdf'
    # light wheels would share the load whether or not they lean
    path.write_text(robot(SKID, rows=(0.15, -0.15)).replace(str(math.pi / 2), roll).replace(
        '"0.001"', '"0.01"').replace('"0.2"/>', '"1.0"/>'))
    report = robot_check.check(str(path))
    assert 'moved while turning' not in [row.what for row in report.rows]
    found = [row.what for row in report.rows if row.what.startswith('moved while turning at')]
    assert found == ['moved while turning at a heading of 0.785 rad'] * drifts
    lines = [line for line in report.warnings if 'it does not drive as asked: ' in line]
    assert len(lines) == drifts
    assert all(line.endswith(
        ' m, asked 0; the axle of left_0_joint leans by 0.0008 rad, so one edge of each wheel '
        'carries the load; if its rpy has 1.57, write 1.5707963') for line in lines), lines


def test_a_robot_that_cannot_be_used_is_refused(check, tmp_path):
    renamed = '<joint name="wheel_left_joint"', '<joint name="axle"'
    assert refusal(check, WHEELS, renamed).startswith(
        'cannot use the robot in {}: the robot has no movable joint wheel_left_joint'.format(
            tmp_path / 'robot.urdf'))


def test_controllers_are_read_from_files(check, tmp_path):
    (tmp_path / 'control.yaml').write_text(CONTROLLERS)
    report = check(CONTROL, parameters=[str(tmp_path / 'control.yaml')])
    expected.check_printed('check_robot/controllers.txt',
                           report.text().replace(str(tmp_path) + '/', ''))
    assert refusal(check, CONTROL, parameters=[str(tmp_path / 'none.yaml')]).startswith(
        'cannot read the parameters in {}: '.format(tmp_path / 'none.yaml'))


@pytest.mark.parametrize('topic, words', [
    ('/clock', 'the topic /clock is not that of a robot; give its plugin another one'),
    ('a b', "command_topic: got 'a b', allowed is a valid topic name")])
def test_a_topic_that_the_node_refuses(check, tmp_path, topic, words):
    assert refusal(check, DRIVE, ('<commandTopic>go<', '<commandTopic>{}<'.format(topic))) == (
        'cannot use the robot in {}: {}'.format(tmp_path / 'robot.urdf', words))
