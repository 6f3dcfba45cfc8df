"""The simulator's gazebo_msgs topics and services in ROS tools, with and without the package."""
import copy
import importlib.util
import math
import os
import sys
import xmlrpc.client

import pytest
import yaml

from img_recog_testing.waiting import wait_for

BURGER = os.path.join(os.path.dirname(__file__), '..', '..', 'urdf', 'turtlebot3_burger.urdf')
MODEL = 'turtlebot3_burger'
NAMES = ['ground_plane', 'turtlebot3_world', MODEL]
INSTALLED = importlib.util.find_spec('gazebo_msgs') is not None

# Definitions from gazebo_msgs of ROS 1 and those that they use, without the comments.
DEFINITIONS = {
    'std_msgs/msg/Header.msg': 'uint32 seq\ntime stamp\nstring frame_id\n',
    'geometry_msgs/msg/Point.msg': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Vector3.msg': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Quaternion.msg': 'float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n',
    'geometry_msgs/msg/Pose.msg': 'Point position\nQuaternion orientation\n',
    'geometry_msgs/msg/Twist.msg': 'Vector3 linear\nVector3 angular\n',
    'gazebo_msgs/msg/ModelState.msg': 'string model_name\ngeometry_msgs/Pose pose\n'
                                      'geometry_msgs/Twist twist\nstring reference_frame\n',
    'gazebo_msgs/msg/ModelStates.msg': 'string[] name\ngeometry_msgs/Pose[] pose\n'
                                       'geometry_msgs/Twist[] twist\n',
    'gazebo_msgs/srv/GetModelState.srv': 'string model_name\nstring relative_entity_name\n---\n'
                                         'Header header\ngeometry_msgs/Pose pose\n'
                                         'geometry_msgs/Twist twist\nbool success\n'
                                         'string status_message\n',
    'gazebo_msgs/srv/SetModelState.srv': 'gazebo_msgs/ModelState model_state\n---\n'
                                         'bool success\nstring status_message\n'}
MANIFEST = ('<package><name>gazebo_msgs</name><version>0.0.0</version><license>none</license>'
            '<description>stand-in</description><maintainer email="a@b.c">a</maintainer>'
            '</package>')
# of the real package, from code that was generated for it
SUMS = {'msg.ModelStates': '48c080191eb15c41858319b4d8a609c2',
        'msg.ModelState': '9330fd35f2fcd82d457e54bd54e10593',
        'srv.GetModelStateResponse': 'ccd51739bb00f0141629e87b792e92b9',
        'srv.SetModelStateRequest': 'cb042b0e91880f4661b29ea5b6234350'}


def write_package(folder):
    """Write a package in place of gazebo_msgs; return the additions to the environment for it."""
    generator = pytest.importorskip('genpy.generator')
    for name, text in DEFINITIONS.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    package = folder / 'gazebo_msgs'
    (package / 'package.xml').write_text(MANIFEST)
    modules = folder / 'python' / 'gazebo_msgs'
    search = {name: [str(folder / name / 'msg')]
              for name in ('std_msgs', 'geometry_msgs', 'gazebo_msgs')}
    for kind, make in (('msg', generator.MsgGenerator), ('srv', generator.SrvGenerator)):
        files = sorted((package / kind).iterdir())
        assert make().generate_messages('gazebo_msgs', [str(file) for file in files],
                                        str(modules / kind), search) == 0
        (modules / kind / '__init__.py').write_text(
            ''.join('from ._{} import *\n'.format(file.stem) for file in files))
    (modules / '__init__.py').write_text('')
    return {'PYTHONPATH': str(modules.parent), 'ROS_PACKAGE_PATH': str(package)}


@pytest.fixture(scope='module')
def gazebo(roscore, tmp_path_factory):
    """A master and a simulator with gazebo_msgs, which ROS tools find too."""
    ros = copy.copy(roscore)
    ros.env = dict(roscore.env)
    if not INSTALLED:
        for name, path in write_package(tmp_path_factory.mktemp('messages')).items():
            ros.env[name] = os.pathsep.join(filter(None, [path, ros.env.get(name)]))
    node = simulate(ros)
    yield ros
    assert node.interrupt() == 0


def simulate(ros):
    with open(BURGER) as file:
        xmlrpc.client.ServerProxy(ros.env['ROS_MASTER_URI']).setParam(
            '/test', '/robot_description', file.read())
    node = ros.start('rosrun', 'img_recog', 'pybullet_sim.py')
    node.wait_output('simulating 1.0017 kg')
    return node


def call(ros, service, request):
    """Return the response of a service of the simulator."""
    text = ros.run('rosservice', 'call', '/gazebo/' + service, yaml.safe_dump(request))
    answer = yaml.safe_load(text)
    assert isinstance(answer, dict), text
    return answer


def get_state(ros, name=MODEL, frame=''):
    return call(ros, 'get_model_state', {'model_name': name, 'relative_entity_name': frame})


def pose(x, y, yaw):
    return {'position': {'x': x, 'y': y, 'z': 0.0},
            'orientation': {'x': 0.0, 'y': 0.0, 'z': math.sin(yaw / 2), 'w': math.cos(yaw / 2)}}


def set_state(ros, x, y, yaw=0.0, name=MODEL, frame='world'):
    return call(ros, 'set_model_state', {'model_state': {
        'model_name': name, 'pose': pose(x, y, yaw), 'reference_frame': frame}})


def assert_at(state, x, y, yaw=0.0):
    """Check a pose. The height is less exact: the robot leans back by 5 mrad on its caster."""
    found = state['pose']
    assert found['position']['x'] == pytest.approx(x, abs=0.01), state
    assert found['position']['y'] == pytest.approx(y, abs=0.01), state
    assert found['position']['z'] == pytest.approx(0.0, abs=0.02), state
    assert 2 * math.atan2(found['orientation']['z'], found['orientation']['w']) == pytest.approx(
        yaw, abs=0.02), state


def newest(echo):
    """Return the newest complete message of a `rostopic echo`."""
    parts = echo.output.split('---\n')
    return yaml.safe_load(parts[-2]) if len(parts) > 1 else None


@pytest.mark.skipif(INSTALLED, reason='gazebo_msgs is installed here')
def test_without_the_package_the_simulator_logs_one_line(ros):
    ros.start('roscore', '-p', ros.port).wait_output('started core service')
    node = simulate(ros)
    lines = [line for line in node.output.splitlines() if 'gazebo_msgs' in line]
    assert len(lines) == 1 and lines[0].startswith('[INFO]'), node.output
    assert lines[0].endswith('gazebo_msgs is not installed: model_states, get_model_state and '
                             'set_model_state are not offered')
    topics = ros.run('rostopic', 'list')
    assert '/gazebo/real_time_factor' in topics and 'model_states' not in topics
    services = ros.run('rosservice', 'list').split()
    assert '/gazebo/pause_physics' in services
    assert not [name for name in services if 'model_state' in name]
    assert node.interrupt() == 0
    assert 'Traceback' not in node.output


@pytest.mark.parametrize('name', list(SUMS))
def test_the_messages_equal_those_of_the_real_package(gazebo, name):
    kind, name = name.split('.')
    code = 'from gazebo_msgs.{} import {name}; print({name}._md5sum)'.format(kind, name=name)
    assert gazebo.run(sys.executable, '-c', code).strip() == SUMS['{}.{}'.format(kind, name)]


def test_model_states_lists_all_models(gazebo):
    echo = gazebo.start('rostopic', 'echo', '-n', '1', '/gazebo/model_states')
    states = wait_for(lambda: newest(echo), lambda: echo.output)
    assert states['name'] == NAMES
    assert [len(states['pose']), len(states['twist'])] == [3, 3]
    for number, (x, y) in enumerate([(0.0, 0.0), (0.0, 0.0), (-2.0, -0.5)]):
        assert_at({'pose': states['pose'][number]}, x, y)
    speeds = [speed for part in states['twist'][2].values() for speed in part.values()]
    assert speeds == pytest.approx([0.0] * 6, abs=0.05)


@pytest.mark.parametrize('frame', ['', 'world'])
def test_state_in_the_world(gazebo, frame):
    answer = get_state(gazebo, frame=frame)
    assert (answer['success'], answer['header']['frame_id']) == (True, 'world')
    assert answer['header']['stamp']['secs'] + answer['header']['stamp']['nsecs'] > 0
    assert_at(answer, -2.0, -0.5)


def test_state_relative_to_itself_and_to_the_world_model(gazebo):
    itself = get_state(gazebo, frame=MODEL)
    assert (itself['success'], itself['header']['frame_id']) == (True, MODEL)
    place, turn = itself['pose']['position'], itself['pose']['orientation']
    assert list(place.values()) == pytest.approx([0.0] * 3, abs=1e-6)
    assert abs(turn['w']) == pytest.approx(1.0)
    assert list(itself['twist']['linear'].values()) == pytest.approx([0.0] * 3, abs=1e-6)
    assert_at(get_state(gazebo, 'turtlebot3_world', MODEL), 2.0, 0.5)


def test_unknown_models_and_frames_are_named(gazebo):
    for answer in (get_state(gazebo, 'waffle'), set_state(gazebo, 0.5, 0.5, frame='waffle')):
        assert answer['success'] is False
        assert answer['status_message'] == "no model 'waffle' (models: {})".format(
            ', '.join(NAMES))


def test_a_refused_state_leaves_the_robot_where_it_is(gazebo):
    answer = set_state(gazebo, float('nan'), 0.5)
    assert answer['success'] is False
    assert answer['status_message'].startswith('state: got [nan, 0.5,')
    assert 'finite numbers' in answer['status_message']
    answer = call(gazebo, 'set_model_state', {'model_state': {'model_name': MODEL}})
    assert answer['success'] is False
    assert 'zero quaternion' in answer['status_message']
    answer = set_state(gazebo, 0.5, 0.5, name='turtlebot3_world')
    assert (answer['success'], answer['status_message']) == (
        False, 'model turtlebot3_world is static')
    assert_at(get_state(gazebo), -2.0, -0.5)


def test_set_state_moves_the_robot_until_the_world_is_reset(gazebo):
    echo = gazebo.start('rostopic', 'echo', '/odom/pose')

    def at(x, y, yaw):
        found = newest(echo)
        if found is None:
            return False
        try:
            assert_at(found, x, y, yaw)
        except AssertionError:
            return False
        return True
    wait_for(lambda: at(-2.0, -0.5, 0.0), lambda: echo.output[-2000:])

    answer = set_state(gazebo, 0.5, 0.5, 1.0)
    assert (answer['success'], answer['status_message']) == (True, '')
    wait_for(lambda: at(0.5, 0.5, 1.0), lambda: echo.output[-2000:])
    assert_at(get_state(gazebo), 0.5, 0.5, 1.0)
    # 10 cm in front of the robot, facing backwards
    assert set_state(gazebo, 0.1, 0.0, -1.0, frame=MODEL)['success'] is True
    assert_at(get_state(gazebo), 0.5 + 0.1 * math.cos(1.0), 0.5 + 0.1 * math.sin(1.0), 0.0)

    assert gazebo.run('rosservice', 'call', '/gazebo/reset_world').strip() == ''
    wait_for(lambda: at(-2.0, -0.5, 0.0), lambda: echo.output[-2000:])
    assert_at(get_state(gazebo), -2.0, -0.5)
