"""The world and robot of a replay are the demo's, or those of the files that are given."""
import pytest

from img_recog.errors import UserError
from img_recog.loading import resources
from img_recog.replay import scenario
from img_recog.simulation.simulation_settings import CameraSettings, SpawnSettings
from img_recog_helpers import robots
from img_recog_helpers.robots import assemble, burger

DRIVE = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>
  <wheelSeparation>0.3</wheelSeparation></plugin></gazebo>
  <gazebo><plugin name="lamp" filename="liblamp.so"/></gazebo></robot>'''
TAG = ('<gazebo reference="{}"><sensor type="camera" name="c"><camera><image><width>{}</width>'
       '<height>48</height></image></camera><plugin name="p" filename="libgazebo_ros_camera.so">'
       '<updateRate>10</updateRate></plugin></sensor></gazebo>')


@pytest.fixture
def robot_file(tmp_path):
    """A function that writes a text and returns its path."""
    def write(text, name='robot.urdf'):
        path = tmp_path / name
        path.write_text(text)
        return str(path)
    return write


def build(path, world='empty', **spawn):
    return scenario.build(world, path, SpawnSettings(**spawn))


def test_the_demos_robot_in_the_demos_world(caplog):
    simulator = build(resources.burger(), resources.DEFAULT_WORLD)
    assert caplog.messages == []
    assert [body.name for body in simulator.world.scenery] == ['turtlebot3_world']
    robot = simulator.robots[0]
    assert robot.body.motion().position[:2] == pytest.approx([-2.0, -0.5])
    readings = simulator.advance(1000)
    assert {reading.sensor for reading in readings} == {'odometry', 'joint_states'}
    assert simulator.robots[0].settings.drive.wheel_separation == 0.160


def test_gazebo_tags_are_settings_and_the_others_are_warned_of(robot_file, caplog):
    path = robot_file(robots.burger('').replace('</robot>', DRIVE))
    robot = build(path, x_pos=1.0).robots[0]
    assert robot.settings.drive.wheel_separation == 0.3
    assert robot.body.motion().position[0] == pytest.approx(1.0)
    unsupported, contradiction = caplog.messages
    assert path in unsupported and 'plugin liblamp.so' in unsupported
    assert path in contradiction and 'in the URDF it is 0.16 m' in contradiction


def test_a_start_inside_of_a_post_is_warned_of(caplog):
    build(resources.burger(), resources.DEFAULT_WORLD, x_pos=-1.1, y_pos=0.0)
    assert len(caplog.messages) == 1
    assert 'turtlebot3_burger in turtlebot3_world' in caplog.messages[0]
    assert caplog.messages[0].endswith('set --x-pos, --y-pos, --z-pos')


def test_a_partial_world_is_an_option_of_the_command_line(tmp_path):
    path = tmp_path / 'a.world'
    path.write_text('<sdf version="1.6"><world name="w"><actor name="walker"/></world></sdf>')
    with pytest.raises(UserError, match='walker; add --allow-partial-world to load the rest$'):
        build(resources.burger(), str(path))


def test_the_burger_has_a_camera_at_its_mount():
    assert scenario.camera_settings(assemble()) == CameraSettings(
        camera_frame='camera_link', camera_optical_frame='head_camera', camera_width=640,
        camera_height=480, camera_rate=30.0)


def test_the_first_camera_of_the_tags_is_used():
    built = assemble(urdf=burger('').replace(
        '</robot>', TAG.format('base_scan', 64) + TAG.format('camera_link', 80) + '</robot>'))
    settings = scenario.camera_settings(built)
    assert (settings.camera_frame, settings.camera_width, settings.camera_rate) == (
        'base_scan', 64, 10.0)


def test_a_robot_without_a_camera_is_refused():
    with pytest.raises(UserError) as refused:
        scenario.camera_settings(assemble(urdf=burger().replace('camera_link', 'mount')))
    assert refused.value.problem == (
        '--camera robot: the robot has no camera: neither a <sensor type="camera"> in its URDF '
        'nor a link camera_link')
    assert '--urdf' in refused.value.advice
