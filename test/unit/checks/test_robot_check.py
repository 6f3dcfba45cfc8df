"""What is said of robots: given, measured or assumed, and how fast they drive."""
import pytest

from img_recog.checks import robot_check
from img_recog.checks.report import Row
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger, whole_burger

DRIVE = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>
  <wheelSeparation>0.16</wheelSeparation><wheelDiameter>0.066</wheelDiameter>
  <commandTopic>go</commandTopic><updateRate>20</updateRate></plugin></gazebo>'''
WHEELS = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint></plugin>
  </gazebo>'''
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
        text = burger().replace('</robot>', tags + '</robot>')
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / 'robot.urdf'
        path.write_text(text)
        return robot_check.check(str(path), **options)
    return run


def found(report, what):
    """Return state, value and source of each row about something."""
    return [(row.state, row.value, row.source) for row in report.rows if row.what == what]


def test_the_burger_has_wheels_that_are_measured_and_drives_as_it_is_told(check, tmp_path):
    report = check(WHEELS)
    assert report.title == 'robot turtlebot3_burger in {}'.format(tmp_path / 'robot.urdf')
    assert (report.warnings, report.problem) == ((), '')
    measured = 'shapes of the wheels'
    assert found(report, 'mass') == [('simulated', '1.002 kg', '')]
    assert found(report, 'wheel_separation') == [('simulated', '0.16 m', measured)]
    assert found(report, 'wheel_diameter') == [('simulated', '0.066 m', measured)]
    assert found(report, 'command_topic') == [('assumed', 'cmd_vel', 'default')]
    assert found(report, 'scan') == [
        ('assumed', 'sensor_msgs/LaserScan on scan, 5 Hz', 'default')]
    assert found(report, 'straight') == [('measured', '0.200 m/s', 'asked 0.2 m/s')]
    assert found(report, 'turning') == [('measured', '0.500 rad/s', 'asked 0.5 rad/s')]


def test_all_of_the_whole_burger_is_in_its_tags(tmp_path):
    path = tmp_path / 'robot.urdf'
    path.write_text(whole_burger())
    report = robot_check.check(str(path))
    assert (report.warnings, report.is_partial) == ((), False)
    assert [row.what for row in report.rows if row.state == 'assumed'] == ['friction']


@pytest.mark.parametrize('tags', ['', LAMP])
def test_a_robot_without_a_drive_is_loaded_and_does_not_drive(check, tags):
    report = check(tags + CAMERA)
    assert report.is_partial and found(report, 'drive') == [('not simulated', 'none', '')]
    assert not [row for row in report.rows if row.state == 'measured' or 'wheel_d' in row.what]
    assert found(report, 'camera on camera_link')[0][0] == 'simulated'
    line, = [each for each in report.warnings if 'does not drive' in each]
    assert 'it does not drive, as it has no drive that is simulated' in line
    assert ('plugin liblamp.so' in line) == bool(tags)


def test_what_tags_give_is_not_assumed(check):
    report = check(DRIVE + CAMERA)
    tag, drive = '<gazebo> tag', 'plugin or controller'
    assert found(report, 'wheel_separation') == [('simulated', '0.16 m', drive)]
    assert found(report, 'command_topic') == [('simulated', 'go', drive)]
    assert found(report, 'odometry') == [('simulated', 'nav_msgs/Odometry on odom, 20 Hz', tag)]
    assert found(report, 'camera on camera_link') == [
        ('simulated', 'eye/image_raw: 320x240, 10 Hz, pinhole', tag)]


def test_friction_is_given_or_assumed(check):
    rows = found(check('', ('<mu1>0.1</mu1>', '<mu1>0.8</mu1>')), 'friction')
    assert rows[0][:2] == ('simulated',
                           '0.8 of wheel_left_link, wheel_right_link, caster_back_link')
    assert rows[1:] == [('assumed', '1 of base_footprint', 'default')]


def test_friction_of_a_link_that_is_fixed_to_one_without_a_shape_is_given(check):
    rows = found(check('<gazebo reference="base_link"><mu1>0.3</mu1></gazebo>'), 'friction')
    assert [row[:2] for row in rows if 'base_footprint' in row[1]] == [
        ('simulated', '0.3 of base_footprint')]


@pytest.mark.parametrize('tags, what, words', [
    ('<gazebo><plugin name="i" filename="libgazebo_ros_imu.so"><frameName>torso</frameName>'
     '</plugin></gazebo>', 'imu', ('not simulated', 'no link torso', '')),
    ('<gazebo reference="wheel"><mu1>1</mu1></gazebo>',
     'the <gazebo> tag, as there is no such link,', ('not used', 'wheel', ''))])
def test_a_tag_of_a_link_that_is_not_there_is_something_that_is_missing(check, tags, what, words):
    report = check(tags)
    assert report.is_partial and found(report, what) == [words]


def test_what_is_not_simulated_is_named_and_warned_of(check):
    report = check(WHEELS + LAMP + MESH, ('imu_link', 'a_link'))
    assert Row('not simulated', 'plugin liblamp.so') in report.rows
    assert Row('not drawn', 'mesh package://lost/x.stl') in report.rows
    assert Row('not simulated', 'imu', 'no link imu_link') in report.rows
    assert [line.rpartition(': ')[2] for line in report.warnings][1:] == [
        'plugin liblamp.so', 'no link imu_link']
    assert 'package://lost/x.stl' in report.warnings[0]


def test_an_inertia_that_no_body_has_is_named(check):
    report = check(WHEELS, ('ixx="1.1175580e-5"', 'ixx="1"'))
    assert found(report, 'inertia of wheel_left_link') == [
        ('assumed', 'the nearest possible one', '')]
    assert 'wheel_left_link' in report.warnings[0]


def test_a_wheel_that_slips_is_measured_at_its_speed(check):
    report = check(DRIVE, ('<wheelDiameter>0.066</wheelDiameter>',
                           '<wheelDiameter>0.132</wheelDiameter>'))
    (_, value, asked), = found(report, 'straight')
    assert (value, asked) == ('0.100 m/s', 'asked 0.2 m/s')
    assert 'wheel_diameter is 0.132 m, but in the URDF it is 0.066 m' in report.warnings[0]


ROLLED = 'rpy="-1.57 0 0"/>\n    <axis xyz="0 0 1"/>'

BACKWARD = 'rpy="-1.57 0 0"/><axis xyz="0 0 -1"/>'


@pytest.mark.parametrize('axis', ['rpy="-1.57 0 0"/>', '/><axis xyz="0 0 1"/>',
                                  '/><axis xyz="0 1 0"/>', BACKWARD],
                         ids=['no axis', 'axis z', 'flat wheels', 'backward'])
def test_a_robot_that_does_not_drive_as_asked_is_measured(check, axis):
    report = check(WHEELS, (ROLLED, axis))
    (_, straight, _), = found(report, 'straight')
    assert report.is_partial
    assert axis == BACKWARD or any('the wheel of wheel_left_joint does not roll forward' in line
                                   for line in report.warnings)
    assert any('it does not drive as asked: straight {}, asked 0.2; see'.format(straight) in line
               for line in report.warnings), report.warnings


def test_a_robot_that_cannot_be_used_is_refused(check, tmp_path):
    renamed = '<joint name="wheel_left_joint"', '<joint name="axle"'
    assert refusal(check, WHEELS, renamed).startswith(
        'cannot use the robot in {}: the robot has no movable joint wheel_left_joint'.format(
            tmp_path / 'robot.urdf'))


def test_controllers_are_read_from_files(check, tmp_path):
    control = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>'
    (tmp_path / 'control.yaml').write_text(
        'base: {type: diff_drive_controller/DiffDriveController, left_wheel: wheel_left_joint,\n'
        '  right_wheel: [wheel_right_joint]}\narm: {type: arm/Arm}\n')
    report = check(control, parameters=[str(tmp_path / 'control.yaml')])
    assert found(report, 'command_topic') == [
        ('simulated', 'base/cmd_vel', 'plugin or controller')]
    assert Row('not simulated', 'controller arm (arm/Arm)') in report.rows
    assert found(report, 'straight') == [('measured', '0.200 m/s', 'asked 0.2 m/s')]
    assert refusal(check, control, parameters=[str(tmp_path / 'none.yaml')]).startswith(
        'cannot read the parameters in {}: '.format(tmp_path / 'none.yaml'))


def test_a_base_that_is_moved_has_no_wheels(check):
    report = check(DRIVE.replace('diff_drive', 'planar_move'))
    assert found(report, 'drive') == [('simulated', 'planar', 'plugin or controller')]
    assert found(report, 'wheel_diameter') == []
    assert found(report, 'turning') == [('measured', '0.500 rad/s', 'asked 0.5 rad/s')]
