"""The simulator's gazebo_msgs topics and services in ROS tools, with and without the package."""
import copy
import itertools
import math
import os
import re
import signal
import sys
import time

import pytest
import yaml

from img_recog_helpers.gazebo_messages import INSTALLED, write_package
from img_recog_helpers.process_table import is_alive
from img_recog_helpers.sdf_robot import POST, ROBOT
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import (Echo, Images, Messages, burger, drawing,
                                               drive, published, with_tags)
from img_recog_helpers.waiting import DEADLINE_S, wait_for

MODEL = 'turtlebot3_burger'
NAMES = ['ground_plane', 'turtlebot3_world', MODEL]
# of the real package, from code that was generated for it
SUMS = {'msg.ModelStates': '48c080191eb15c41858319b4d8a609c2',
        'msg.ContactsState': 'acbcb1601a8e525bf72509f18e6f668d',
        'msg.ModelState': '9330fd35f2fcd82d457e54bd54e10593',
        'msg.LinkState': '0818ebbf28ce3a08d48ab1eaa7309ebe',
        'srv.GetModelStateResponse': 'ccd51739bb00f0141629e87b792e92b9',
        'srv.SetModelStateRequest': 'cb042b0e91880f4661b29ea5b6234350',
        'srv.SpawnModelRequest': '6d0eba5753761cd57e6263a056b79930',
        'srv.GetWorldPropertiesResponse': '36bb0f2eccf4d8be971410c22818ba3f',
        'srv.GetPhysicsPropertiesResponse': '575a5e74786981b7df2e3afc567693a6',
        'msg.LinkStates': '48c080191eb15c41858319b4d8a609c2',
        'srv.GetLinkState': '09d6c98cce97b35f7ab9bd70300657ab',
        'srv.GetLinkProperties': '0e06a70386d0ee3fb880c02f23fcd821',
        'srv.GetJointProperties': '7b30be900f50aa21efec4a0ec92d91c9',
        'srv.GetModelProperties': '5717f7bd34ed990fa80e28b3015027a3',
        'srv.SetModelConfiguration': '10e3139d3b669c40afc057d38956fff7',
        'srv.SetPhysicsProperties': '97e2057080558ce4730434b5fae75c91',
        'srv.ApplyBodyWrench': '585b9f9618aa0581b207e2f2d90866bc',
        'srv.ApplyJointEffort': 'c0039811b8cc919490b3cff748cdf46b',
        'srv.BodyRequest': '5eade9afe7f232d78005bd0cafeab755',
        'srv.JointRequest': '0be1351618e1dc030eb7959d9a4902de'}


@pytest.fixture(scope='module')
def gazebo(roscore, tmp_path_factory):
    """A master and a simulator with gazebo_msgs, which ROS tools find too."""
    ros = copy.copy(roscore)
    ros.env = dict(roscore.env)
    if not INSTALLED:
        for name, path in write_package(tmp_path_factory.mktemp('messages')).items():
            ros.env[name] = os.pathsep.join(filter(None, [path, ros.env.get(name)]))
    ros.simulator = node = simulate(ros)
    ros.services = ServiceCalls(ros)
    yield ros
    ros.services.close()
    assert node.interrupt() == 0


# a bar in front of the burger
BUMPER = '''<link name="bar"><collision><origin xyz="0.08 0 0.05"/><geometry>
  <box size="0.02 0.1 0.02"/></geometry></collision></link>
<joint name="bar_joint" type="fixed"><parent link="base_link"/><child link="bar"/></joint>
<gazebo reference="bar"><sensor type="contact" name="b"><update_rate>20</update_rate>
  <contact><collision>bar_collision</collision></contact>
  <plugin name="b" filename="libgazebo_ros_bumper.so"><bumperTopicName>bumper</bumperTopicName>
  <frameName>bar_frame</frameName></plugin></sensor></gazebo>'''


def simulate(ros):
    ros.set_parameters('/robot_description', burger(BUMPER))
    node = ros.start_node('pybullet_sim.py')
    node.wait_output('simulating 1.0017 kg')
    return node


def call(ros, service, request):
    """Return the response of a service of the simulator."""
    answer = ros.services.call('/gazebo/' + service, request)
    assert isinstance(answer, dict), answer
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


def test_without_the_package_the_simulator_says_why(ros, tmp_path):
    # installed, but a package that it needs is not
    (tmp_path / 'gazebo_msgs').mkdir()
    (tmp_path / 'gazebo_msgs' / '__init__.py').write_text('import trajectory_messages\n')
    ros.env['PYTHONPATH'] = '{}:{}'.format(tmp_path, ros.env['PYTHONPATH'])
    ros.start_master()
    node = simulate(ros)
    reason = "gazebo_msgs cannot be loaded: No module named 'trajectory_messages'"
    bumper, services = [line for line in node.output.splitlines() if 'gazebo_msgs' in line]
    assert bumper.endswith('not simulated: sensor contact ({})'.format(
        reason))
    assert services.startswith('[INFO]') and services.endswith(
        'model_states and the services of models are not offered, because ' + reason)
    assert '/gazebo/real_time_factor' in published(ros)
    names = [name for kind in ros.master().getSystemState('/test')[2] for name, _ in kind]
    assert '/gazebo/pause_physics' in names
    assert not [name for name in names if 'model_state' in name]
    assert node.interrupt() == 0
    assert 'Traceback' not in node.output


def test_the_messages_equal_those_of_the_real_package(gazebo):
    code = 'import gazebo_msgs.msg, gazebo_msgs.srv\n' + ''.join(
        'print(gazebo_msgs.{}._md5sum)\n'.format(name) for name in SUMS)
    found = gazebo.run(sys.executable, '-c', code).split()
    assert dict(zip(SUMS, found)) == SUMS and len(found) == len(SUMS)


def test_model_states_lists_all_models(gazebo):
    echo = gazebo.start('rostopic', 'echo', '-n', '1', '/gazebo/model_states')
    states = wait_for(lambda: newest(echo), lambda: echo.output)
    assert states['name'] == NAMES
    assert [len(states['pose']), len(states['twist'])] == [3, 3]
    for number, (x, y) in enumerate([(0.0, 0.0), (0.0, 0.0), (-2.0, -0.5)]):
        assert_at({'pose': states['pose'][number]}, x, y)
    speeds = [speed for part in states['twist'][2].values() for speed in part.values()]
    assert speeds == pytest.approx([0.0] * 6, abs=0.05)


def test_states_in_the_world_and_relative_to_models(gazebo):
    for frame in ('', 'world'):
        answer = get_state(gazebo, frame=frame)
        assert (answer['success'], answer['header']['frame_id']) == (True, 'world')
        assert answer['header']['stamp']['secs'] + answer['header']['stamp']['nsecs'] > 0
        assert_at(answer, -2.0, -0.5)
    itself = get_state(gazebo, frame=MODEL)
    assert (itself['success'], itself['header']['frame_id']) == (True, MODEL)
    assert list(itself['pose']['position'].values()) == pytest.approx([0.0] * 3, abs=1e-6)
    assert_at(get_state(gazebo, 'turtlebot3_world', MODEL), 2.0, 0.5)


def test_set_state_moves_the_robot_until_the_world_is_reset(gazebo):
    place = Echo(gazebo, '/odom/pose/pose/position')

    def wait_odometry(x, y):
        place.wait(lambda *found: math.dist(found[:2], (x, y)) < 0.01, (x, y))
    wait_odometry(-2.0, -0.5)
    answer = set_state(gazebo, 0.5, 0.5, 1.0)
    assert (answer['success'], answer['status_message']) == (True, '')
    wait_odometry(0.5, 0.5)
    assert_at(get_state(gazebo), 0.5, 0.5, 1.0)
    # 10 cm in front of the robot, facing backwards
    assert set_state(gazebo, 0.1, 0.0, -1.0, frame=MODEL)['success'] is True
    assert_at(get_state(gazebo), 0.5 + 0.1 * math.cos(1.0), 0.5 + 0.1 * math.sin(1.0), 0.0)
    assert gazebo.services.call('/gazebo/reset_world', {}) is None
    wait_odometry(-2.0, -0.5)
    place.close()


GOAL = """<?xml version='1.0'?>
<sdf version='1.6'><model name='any'><static>1</static><link name='l'>
  <collision name='c'><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision>
  <visual name='v'><pose>0 0 0.001 0 0 0</pose>
    <geometry><box><size>4 4 0.001</size></box></geometry>
    <material><script><name>Gazebo/Red</name></script></material>
  </visual></link></model></sdf>"""


def spawn(ros, name, text, x=0.0, y=0.0, z=0.0, frame='world', service='spawn_sdf_model'):
    # like turtlebot3_machine_learning: the orientation stays a quaternion of zeros
    return call(ros, service, {'model_name': name, 'model_xml': text,
                               'robot_namespace': 'robotos_name_space', 'reference_frame': frame,
                               'initial_pose': {'position': {'x': x, 'y': y, 'z': z}}})


def names(ros):
    answer = call(ros, 'get_world_properties', {})
    assert (answer['success'], answer['rendering_enabled']) == (True, True)
    return answer['model_names']


def publish(ros, topic, kind, **fields):
    """Publish a message five times a second; return the process that does so."""
    return ros.start('rostopic', 'pub', '-r', '5', '/gazebo/' + topic, 'gazebo_msgs/' + kind,
                     yaml.safe_dump(fields))


@pytest.mark.parametrize('topic, kind, field, name', [
    ('set_model_state', 'ModelState', 'model_name', MODEL),
    ('set_link_state', 'LinkState', 'link_name', MODEL + '::base_footprint')])
def test_states_are_set_by_topics_too(gazebo, topic, kind, field, name):
    assert set_state(gazebo, -2.0, -0.5)['success'] is True
    publisher = publish(gazebo, topic, kind, pose=pose(0.5, 0.5, 1.0), reference_frame='world',
                        **{field: name})
    wait_for(lambda: abs(get_state(gazebo)['pose']['position']['x'] - 0.5) < 0.01,
             lambda: publisher.output)
    assert_at(get_state(gazebo), 0.5, 0.5, 1.0)
    publisher.interrupt()
    assert call(gazebo, 'set_link_state', {'link_state': {
        'link_name': MODEL + '::base_footprint', 'pose': pose(-2.0, -0.5, 0.0)}}) == {
            'success': True, 'status_message': ''}
    assert_at(get_state(gazebo), -2.0, -0.5)


@pytest.mark.parametrize('topic, kind, fields, problem', [
    ('set_model_state', 'ModelState', {'model_name': 'waffle'}, "no model 'waffle' (models: "),
    ('set_link_state', 'LinkState', {'link_name': MODEL},
     "link_name: got '{}', expected MODEL::LINK".format(MODEL))])
def test_a_bad_message_is_one_line_of_the_log(gazebo, topic, kind, fields, problem):
    publisher = publish(gazebo, topic, kind, **fields)
    gazebo.simulator.wait_output(r'\[WARN\].*ignored a message on /gazebo/{}: {}'.format(
        topic, re.escape(problem)))
    publisher.interrupt()
    assert 'Traceback' not in gazebo.simulator.output


def has_red(image):
    return image['red']['share'] > 0.02


def has_no_red(image):
    return image['red']['share'] == 0.0


def test_a_goal_is_added_seen_moved_and_deleted(gazebo):
    images = Images(gazebo)
    images.wait(has_no_red)
    assert spawn(gazebo, 'goal', GOAL, 1.0, 1.0) == {'success': True, 'status_message': ''}
    assert names(gazebo) == NAMES + ['goal']
    assert_at(get_state(gazebo, 'goal'), 1.0, 1.0)
    images.wait(has_red)
    assert set_state(gazebo, 90.0, 0.0, name='goal')['success'] is True
    images.wait(has_no_red)
    assert set_state(gazebo, 1.0, 1.0, name='goal')['success'] is True
    images.wait(has_red)
    assert call(gazebo, 'delete_model', {'model_name': 'goal'}) == {
        'success': True, 'status_message': ''}
    images.wait(has_no_red)
    images.close()
    assert names(gazebo) == NAMES


def test_urdf_is_added_in_a_frame(gazebo):
    text = ("<robot name='b'><link name='l'><inertial><mass value='1'/><inertia ixx='0.01' "
            "ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.01'/></inertial><collision><geometry>"
            "<box size='0.2 0.2 0.2'/></geometry></collision></link></robot>")
    assert spawn(gazebo, 'box', text, 0.4, 0.0, 0.15, MODEL,
                 'spawn_urdf_model')['success'] is True
    found = get_state(gazebo, 'box', MODEL)['pose']['position']
    assert call(gazebo, 'delete_model', {'model_name': 'box'})['success'] is True
    assert [found['x'], found['y']] == pytest.approx([0.4, 0.0], abs=0.05)


def test_a_robot_and_a_scanner_of_an_sdf_are_added_with_their_topics_and_deleted(gazebo):
    text = '<sdf version="1.6">{}</sdf>'
    for name, model in ('bot', ROBOT.format('')), ('post', POST):
        assert spawn(gazebo, name, text.format(model), 20.0, 5.0)['success'] is True
    odometry, scan = (Messages(gazebo, topic) for topic in ('/robotos_name_space/odom', '/watch'))
    assert odometry.wait_more(1)[0].header.frame_id == 'bot_odom'
    assert scan.wait_more(1)[0].ranges
    odometry.close()
    scan.close()
    for name in ('bot', 'post'):
        assert call(gazebo, 'delete_model', {'model_name': name})['success'] is True
    assert not {'/watch', '/robotos_name_space/front'} & published(gazebo)
    assert names(gazebo) == NAMES


def test_a_robot_with_a_drive_is_added_with_its_topics_and_deleted(gazebo):
    text = burger()
    assert spawn(gazebo, 'second', text, 0.5, 0.55, service='spawn_urdf_model') == {
        'success': True, 'status_message': ''}
    assert names(gazebo) == NAMES + ['second']
    assert_at(get_state(gazebo, 'second'), 0.5, 0.55)
    odometry = Messages(gazebo, '/robotos_name_space/odom')
    assert odometry.wait_more(1)[0].header.frame_id == 'robotos_name_space/odom'
    odometry.close()
    assert set_state(gazebo, 0.5, -0.55, name='second')['success'] is True
    assert_at(get_state(gazebo, 'second'), 0.5, -0.55)
    for name, problem in (('third', "there is a robot with the namespace 'robotos_name_space' "
                           'already; give it another robot_namespace'),
                          ('second', 'there is a model second already; give another name')):
        answer = spawn(gazebo, name, text, 0.5, 0.55)
        assert (answer['success'], answer['status_message']) == (False, problem)
    assert call(gazebo, 'delete_model', {'model_name': 'second'})['success'] is True
    assert names(gazebo) == NAMES
    wait_for(lambda: 'robotos_name_space' not in str(gazebo.master().getSystemState('/test')),
             'no topics')


TILTED = {'position': {'x': 0.5, 'y': 0.55, 'z': 0.0},
          'orientation': {'x': 1.0, 'y': 0.0, 'z': 0.0, 'w': 0.0}}


def third(text, namespace='third', where=pose(0.5, 0.55, 0.0), name='third'):
    return {'model_name': name, 'model_xml': text, 'robot_namespace': namespace,
            'initial_pose': where}


# what else is refused, and why, is in the tests of what the services call
@pytest.mark.parametrize('service, request_, problem', [
    ('get_model_state', {'model_name': 'waffle'},
     "no model 'waffle' (models: {})".format(', '.join(NAMES))),
    ('set_model_state', {'model_state': {'model_name': MODEL, 'reference_frame': 'waffle'}},
     "no model 'waffle' (models: "),
    ('set_model_state', {'model_state': {'model_name': MODEL, 'pose': pose(math.nan, 0.5, 0.0)}},
     'state: got [nan, 0.5,'),
    ('set_link_state', {'link_state': {'link_name': MODEL + '::wheel_left_link'}},
     "model {} has no link 'wheel_left_link' without a joint above it".format(MODEL)),
    ('delete_model', {'model_name': 'goal'}, "no model 'goal' (models: "),
    *(('spawn_sdf_model', third(text, name=name), "model_name: got '{}', allowed is a ".format(
        name)) for name in ('', 'a::b') for text in (GOAL, burger())),
    ('spawn_sdf_model', third('no markup'), 'model third: '),
    ('spawn_sdf_model',
     third('<sdf version="1.6"><include><uri>model://gone</uri></include></sdf>'),
     'model third: not found, or not supported: model://gone; set GAZEBO_MODEL_PATH to'),
    ('spawn_urdf_model', third(burger(), 'a b'), "robot_namespace: got 'a b', wants names"),
    ('spawn_urdf_model', third(burger(), '~x'), "robot_namespace: got '~x', wants names"),
    ('spawn_urdf_model', third(burger(), where=TILTED), 'a robot starts upright: got roll 3.142'),
    ('spawn_urdf_model', third(with_tags(commandTopic='/odom')),
     'a sensor and commands are on the topic /third/odom; give each another topic'),
    ('get_link_state', {'link_name': MODEL + '::none'},
     "model {} has no link 'none' (links: base_footprint, ".format(MODEL)),
    ('get_link_state', {'link_name': MODEL + '::base_footprint', 'reference_frame': 'waffle'},
     "no model 'waffle' (models: "),
    ('get_link_properties', {'link_name': 'none'}, "no model 'none' (models: "),
    ('get_joint_properties', {'joint_name': 'none'}, "no movable joint 'none' (movable joints: "),
    ('get_model_properties', {'model_name': 'none'}, "no model 'none' (models: "),
    ('apply_joint_effort', {'joint_name': 'none'}, "no movable joint 'none' (movable joints: "),
    ('apply_body_wrench', {'body_name': 'none'}, "no model 'none' (models: "),
    ('set_model_configuration', {'model_name': MODEL, 'joint_names': ['wheel_left_joint']},
     'got 1 joint_names and 0 joint_positions; give a position for each joint'),
    ('set_physics_properties', {'time_step': 0.002}, 'time_step: got 0.002'),
    ('set_physics_properties', {'time_step': 0.001, 'max_update_rate': -1.0}, 'real_time_factor'),
    ('set_physics_properties', {'time_step': 0.001, 'gravity': {'z': math.nan}}, 'gravity: got ')])
def test_what_is_refused_changes_nothing(gazebo, service, request_, problem):
    before = call(gazebo, 'get_physics_properties', {})
    answer = call(gazebo, service, request_)
    assert answer['success'] is False and answer['status_message'].startswith(problem), answer
    assert names(gazebo) == NAMES and call(gazebo, 'get_physics_properties', {}) == before


def test_boxes_that_touch_in_too_many_points_do_not_stop_time(gazebo):
    box = ('<link name="l{}"><collision name="c"><geometry><box><size>1 1 1</size></box>'
           '</geometry></collision></link>')
    text = '<sdf version="1.6"><model name="m"><self_collide>1</self_collide>{}</model></sdf>'
    gazebo.services.call('/gazebo/pause_physics', {})
    for name, count in (('some', 45), ('many', 90)):
        links = ''.join(map(box.format, range(count)))
        answer = spawn(gazebo, name, text.format(links), 50.0, 0.0, 5.0)
        assert answer['success'] is (name == 'some'), answer
    assert answer['status_message'].startswith(
        'the next step of the physics would take more than 10 s: bodies touch or overlap in many')
    gazebo.simulator.wait_output('model some: the next step of the physics takes about 2 s: ')
    assert call(gazebo, 'delete_model', {'model_name': 'some'})['success'] is True
    gazebo.services.call('/gazebo/unpause_physics', {})
    before_s = call(gazebo, 'get_world_properties', {})['sim_time']
    wait_for(lambda: call(gazebo, 'get_world_properties', {})['sim_time'] > before_s, 'time')
    assert names(gazebo) == NAMES


def test_physics_properties(gazebo):
    def describe(is_paused=False):
        found = call(gazebo, 'get_physics_properties', {})
        assert (found['success'], found['pause']) == (True, is_paused)
        return [found['time_step'], found['max_update_rate'], *found['gravity'].values()]

    def change(rate, z):
        assert call(gazebo, 'set_physics_properties', {
            'time_step': 0.001, 'max_update_rate': rate, 'gravity': {'z': z}}) == {
                'success': True, 'status_message': 'ode_config is not used'}
        assert describe() == pytest.approx([0.001, rate, 0.0, 0.0, z])
    assert describe() == pytest.approx([0.001, 1000.0, 0.0, 0.0, -9.8])
    gazebo.services.call('/gazebo/pause_physics', {})
    describe(is_paused=True)
    gazebo.services.call('/gazebo/unpause_physics', {})
    change(500.0, -1.6)
    assert gazebo.master().getParam('/test', '/gazebo/real_time_factor')[2] == 0.5
    imu = Echo(gazebo, '/imu/linear_acceleration/z')
    imu.wait(lambda z: abs(z - 1.6) < 0.5, 'less gravity')
    imu.close()
    change(1000.0, -9.8)


# a rod on a vertical axis of the world: an effort of 1 N m makes it faster by 1 rad/s in a second
ROD = """<robot name="rod"><link name="world"/>
<link name="beam"><inertial><origin xyz="0.5 0 0"/><mass value="1"/><inertia ixx="0.75" iyy="0.75"
  izz="0.75" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pivot" type="revolute"><parent link="world"/><child link="beam"/>
  <origin xyz="0 0 2"/><axis xyz="0 0 1"/>
  <limit lower="-3" upper="3" effort="2" velocity="100"/></joint></robot>"""
LINKS = [MODEL + '::' + link for link in ('base_footprint', 'wheel_left_link',
                                          'wheel_right_link')]


@pytest.fixture
def rod(gazebo):
    """The rod, in a simulation that is paused."""
    gazebo.services.call('/gazebo/pause_physics', {})
    assert spawn(gazebo, 'rod', ROD, 5.0, service='spawn_urdf_model')['success'] is True
    yield 'rod::beam'
    gazebo.services.call('/gazebo/unpause_physics', {})
    assert call(gazebo, 'delete_model', {'model_name': 'rod'})['success'] is True


def pivot(gazebo):
    """Return position and rate of its joint."""
    found = call(gazebo, 'get_joint_properties', {'joint_name': 'pivot'})
    assert (found['success'], found['type'], found['damping']) == (True, 0, [])
    return [*found['position'], *found['rate']]


def step(gazebo, count=1):
    """Let steps of 33 ms pass."""
    for _ in range(count):
        assert gazebo.services.call('/gazebo/step', {})['success'] is True


def test_the_states_of_links(gazebo, rod):
    echo = gazebo.start('rostopic', 'echo', '/gazebo/link_states')

    def states():
        step(gazebo)
        return newest(echo)
    found = wait_for(states, lambda: echo.output)
    # in the world of this package, only the floor and the robot have links by Gazebo's names
    assert found['name'] == ['ground_plane::link', *LINKS, rod]
    assert [len(found['pose']), len(found['twist'])] == [5, 5]
    assert found['pose'][4]['position'] == {'x': 5.0, 'y': 0.0, 'z': 2.0}
    seen = call(gazebo, 'get_link_state', {'link_name': LINKS[1], 'reference_frame': LINKS[2]})
    assert (seen['success'], seen['status_message']) == (True, '')
    state = seen['link_state']
    assert (state['link_name'], state['reference_frame']) == (LINKS[1], LINKS[2])
    # the wheels are turned, so that their axes z point to the left
    assert [state['pose']['position'][axis] for axis in 'xyz'] == pytest.approx(
        [0.0, 0.0, 0.16], abs=1e-3)
    # like in Gazebo, the model may be left out
    assert call(gazebo, 'get_link_state', {'link_name': 'beam', 'reference_frame': 'map'}
                )['link_state']['pose']['position'] == {'x': 5.0, 'y': 0.0, 'z': 2.0}


def test_properties_of_links_and_models(gazebo, rod):
    link = call(gazebo, 'get_link_properties', {'link_name': rod})
    assert [link[name] for name in ('mass', 'ixx', 'ixy', 'izz', 'gravity_mode', 'success')] == [
        1.0, 0.75, 0.0, 0.75, True, True]
    assert link['com']['position'] == {'x': 0.5, 'y': 0.0, 'z': 0.0}
    for model, links, joints, is_static in (
            ('rod', ['beam'], ['pivot'], False), ('ground_plane', ['link'], [], True),
            (MODEL, [link.partition('::')[2] for link in LINKS],
             ['wheel_left_joint', 'wheel_right_joint'], False)):
        found = call(gazebo, 'get_model_properties', {'model_name': model})
        assert [found[name] for name in ('body_names', 'joint_names', 'is_static', 'success')] == [
            links, joints, is_static, True]


def test_efforts_and_wrenches_act_for_their_durations_or_until_they_are_cleared(gazebo, rod):
    def effort(value, seconds, nanoseconds=0):
        answer = call(gazebo, 'apply_joint_effort', {
            'joint_name': 'pivot', 'effort': value,
            'duration': {'secs': seconds, 'nsecs': nanoseconds}})
        assert answer['success'] is True
        return answer['status_message']

    def push(seconds, nanoseconds=0):       # at its center, 0.5 m from the pivot
        assert call(gazebo, 'apply_body_wrench', {
            'body_name': rod, 'reference_frame': 'world', 'wrench': {'force': {'y': 2.0}},
            'duration': {'secs': seconds, 'nsecs': nanoseconds}}) == {
                'success': True, 'status_message': ''}

    def turns(rate, steps=1):
        step(gazebo, steps)
        assert pivot(gazebo)[1] == pytest.approx(rate, rel=1e-3)
    assert effort(5.0, 0, 20000000) == ''       # more than its limit of 2 N m
    turns(0.04, 2)
    assert effort(-1.0, -1) == ''
    turns(0.04 - 0.066, 2)
    gazebo.services.call('/gazebo/clear_joint_forces', {'joint_name': 'pivot'})
    turns(0.04 - 0.066)
    assert effort(1.0, 0, 100) == 'duration: a step of 0.001 s is the least'
    turns(0.04 - 0.065)
    push(0, 33000000)
    turns(0.04 - 0.032)
    push(-1)
    turns(0.041)
    gazebo.services.call('/gazebo/clear_body_wrenches', {'body_name': rod})
    turns(0.041)
    gazebo.services.call('/gazebo/clear_body_wrenches', {'body_name': 'none'})


def test_joints_are_put_where_asked(gazebo, rod):
    for asked, found in ((1.0, 1.0), (4.0, 3.0)):
        assert call(gazebo, 'set_model_configuration', {
            'model_name': 'rod', 'joint_names': ['pivot'], 'joint_positions': [asked]}) == {
                'success': True, 'status_message': ''}
        assert pivot(gazebo) == [found, 0.0]


def test_a_bumper_reports_what_it_touches(gazebo):
    contacts = gazebo.start('rostopic', 'echo', '/bumper')
    set_state(gazebo, -2.0, -0.5)
    contacts.wait_output(r'frame_id: "bar_frame"\nstates: \[\]')
    # against the post of turtlebot3_world at x -1.1, y 0, of the radius 0.15 m
    set_state(gazebo, -1.4, 0.0)
    drive(gazebo, 0.2)
    contacts.wait_output('collision1_name: "turtlebot3_burger::bar::collision"\n'
                         ' +collision2_name: "turtlebot3_world::.*::collision"')
    drive(gazebo, 0.0)


def test_a_static_model_that_is_moved_all_the_time_is_seen(gazebo):
    seen = Echo(gazebo, '/gazebo/view/image_raw/header/seq')

    def move_until_seen(what):
        # begins while the scene is loaded, and goes on while it is drawn
        count = len(seen.rows)
        for number in itertools.count():
            set_state(gazebo, 0.01 * (number % 2), 0.0, name='turtlebot3_world')
            if len(seen.rows) >= count + 2:
                return
            assert number < 20 * DEADLINE_S, what
            time.sleep(0.05)
    move_until_seen('no image')
    first = drawing(gazebo.simulator)
    os.kill(first, signal.SIGKILL)
    wait_for(lambda: not is_alive(first), 'the end of the process that draws')
    move_until_seen('no image of another process')
    assert drawing(gazebo.simulator) not in (None, first)
    set_state(gazebo, 0.0, 0.0, name='turtlebot3_world')
