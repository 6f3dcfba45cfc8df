"""The list of robots: from a number, from a file, and what is wrong with one of them."""
import pytest

from img_recog.nodes.robots import robot_list
from img_recog.nodes.robots.robot_list import NodeSettings, RobotListError
from img_recog_helpers import expected

DEFAULTS = {'urdf': '/u/burger.urdf', 'colors': '/c/colors.yaml', 'camera': 'synthetic',
            'image_width': 320}


def find(uri):
    return {'package://p/a.urdf': '/p/a.urdf'}.get(uri)


def read(robots):
    return robot_list.read_robots(robots, DEFAULTS, find)


@pytest.fixture
def listed(tmp_path):
    """A function that writes a list and reads it."""
    def read_text(text):
        path = tmp_path / 'robots.yaml'
        path.write_text(text)
        return read(str(path))
    return read_text


@pytest.mark.parametrize('count', ['1', '4', ' 100 '])
def test_a_number_gives_the_names_of_multi_turtlebot3(count):
    found = read(count)
    assert [robot.name for robot in found.robots] == [
        'tb3_{}'.format(number) for number in range(int(count))]
    assert found.problems == {}
    assert {robot.nodes for robot in found.robots} == {NodeSettings(**DEFAULTS)}
    assert all(robot.simulation == {} for robot in found.robots)


@pytest.mark.parametrize('count', ['0', '-1', '101', '1000'])
def test_other_numbers_are_refused(count):
    with pytest.raises(RobotListError) as error:
        read(count)
    assert str(error.value) == (
        "robots: got {}, allowed is a number from 1 to 100, or the path of a YAML file".format(
            count))


def test_a_list_gives_each_robot_its_own(listed, tmp_path):
    found = listed('- name: a\n'
                   '- {name: b, x_pos: 1, y_pos: -2.5, yaw: 0.5, camera: robot, colors: my.yaml,'
                   ' urdf: "package://p/a.urdf", framerate: 5, simulation: {scan_noise: 0.0}}\n')
    first, second = found.robots
    assert found.problems == {}
    assert first.simulation == {} and first.nodes == NodeSettings(**DEFAULTS)
    assert second.simulation == {'x_pos': 1, 'y_pos': -2.5, 'yaw': 0.5, 'scan_noise': 0.0}
    assert second.nodes == NodeSettings(urdf='/p/a.urdf', colors=str(tmp_path / 'my.yaml'),
                                        camera='robot', image_width=320, framerate=5.0)


@pytest.mark.parametrize('url, kept', [
    ('file://my.yaml', 'file://{}/my.yaml'), ('file:///my.yaml', 'file:///my.yaml'),
    ('file://${ROS_HOME}/my.yaml', 'file://${ROS_HOME}/my.yaml'),
    ('package://p/my.yaml', 'package://p/my.yaml'), ('', '')])
def test_a_calibration_may_be_beside_the_list(listed, tmp_path, url, kept):
    robot, = listed('- {name: a, safe: true, camera_info_url: "%s"}\n' % url).robots
    assert robot.nodes == NodeSettings(**{
        **DEFAULTS, 'safe': True, 'camera_info_url': kept.replace('{}', str(tmp_path))})


def test_one_that_is_wrong_does_not_keep_the_others_out(listed, tmp_path):
    def problem(entry):
        found = listed('- name: good\n- {}\n- name: last\n'.format(entry))
        assert [robot.name for robot in found.robots] == ['good', 'last']
        line, = map(': '.join, found.problems.items())
        assert '\n' not in line
        return line.replace(str(tmp_path), '')
    expected.check_cases('refused/robots.txt', problem)


@pytest.mark.parametrize('text, words', [
    ('', 'got nothing, expected a list of 1 to 100 robots'), ('[]', 'got 0 robots'),
    ('a: 1', 'got dict'), ('"text"', 'got str'), ('[', 'cannot read'),
    ('- name: a\n' * 101, 'got 101 robots')])
def test_what_is_not_a_list_is_refused(listed, text, words):
    with pytest.raises(RobotListError) as error:
        listed(text)
    assert words in str(error.value) and '\n' not in str(error.value)


def test_a_camera_beside_the_list_is_found(listed, tmp_path):
    (tmp_path / 'a.mp4').write_text('')
    cameras = {'a.mp4': str(tmp_path / 'a.mp4'), 'auto': 'synthetic', 'robot': 'robot',
               'http://host/a': 'http://host/a', str(tmp_path): str(tmp_path)}
    found = listed(''.join('- {{name: r{}, camera: "{}"}}\n'.format(number, camera)
                           for number, camera in enumerate(cameras)))
    assert found.problems == {}
    assert [robot.nodes.camera for robot in found.robots] == list(cameras.values())


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(RobotListError, match='robots: cannot read .*none.yaml: .*No such file'):
        read(str(tmp_path / 'none.yaml'))


def test_the_name_of_one_that_is_wrong_is_used_too(listed):
    """Else a robot of this name would be in the simulator, without nodes."""
    found = listed('- {name: b, foo: 1}\n- {name: b}\n- {name: c}\n')
    assert [robot.name for robot in found.robots] == ['c'] and len(found.problems) == 2
    assert 'the name b is used by a robot before it' in found.problems['robot 2 of the list']
