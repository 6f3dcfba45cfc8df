"""Several robots: those of the parameters, added and removed; bad lists; the nodes of each."""
import os
import re
import signal
import sys

import pytest

from img_recog_helpers import process_table, wire
from img_recog_helpers.launch_config import launch_config
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import Messages, burger
from img_recog_helpers.waiting import wait_for


def simulated(ros):
    """Return the names of the robots that are simulated."""
    published = ros.master().getSystemState('/test')[2][0]
    found = (re.fullmatch('/(.*)/odom', topic) for topic, nodes in published if '/gazebo' in nodes)
    return sorted(match.group(1) for match in found if match)


def running(ros, namespace):
    """Return the names of the nodes in a namespace that run.

    One that ends on a busy machine, or is killed, may leave its name.
    """
    state = ros.master().getSystemState('/test')[2]
    names = {node for kind in state for _, nodes in kind for node in nodes}
    return sorted(name for name in names if name.startswith('/{}/'.format(namespace))
                  and wire.pid_of(ros.master_uri, name))


@pytest.fixture
def several(shared_ros):
    """A function that starts the simulator with robots in ~robots."""
    def start(robots, *parameters):
        shared_ros.set_parameters('/robot_description', burger())
        shared_ros.set_parameters('/gazebo', {'robots': robots})
        return shared_ros.start_node('pybullet_sim.py', '_several_robots:=true', '_world:=empty',
                                     *parameters)
    return start


def test_robots_that_fail_do_not_keep_the_others_out(shared_ros, several):
    shared_ros.set_parameters('/broken/robot_description', '<robot name="a"/>')
    shared_ros.set_parameters('/use_sim_time', False)
    node = several({'tb3_0': {'x_pos': 1.0}, 'tb3_1': {'x_pos': 1.05}, 'broken': {},
                    'typo': {'x_pso': 1.0}, 'wrong': {'x_pos': 'far'}, 'tb3_10': {},
                    'topic': {'scan_topic': 'no name!'}, 'same': {'scan_topic': 'odom'},
                    'use_sim_time': {}, 'number': 5})
    node.wait_output('simulating 2 robots in world empty')
    for line in (
            r'robot tb3_1 is not simulated: cannot use the robot in robot_description: it would '
            r'start inside of tb3_0; give it another x_pos, y_pos or z_pos',
            r'robot broken is not simulated: cannot use the robot in /broken/robot_description: ',
            r'robot typo is not simulated: parameter /gazebo/robots/typo/x_pso is unknown to this '
            r'node: did you mean x_pos\?',
            r"robot topic is not simulated: parameter scan_topic: got 'no name!', allowed is a "
            r'valid topic name',
            r'robot same is not simulated: two sensors are on the topic /same/odom; give each '
            r'another topic',
            r'robot use_sim_time is not simulated: parameter /use_sim_time: got False, wants a '
            r'mapping',
            r'robot number is not simulated: parameter /gazebo/robots/number: got 5, wants a '
            r'mapping',
            r"robot wrong is not simulated: parameter /gazebo/robots/wrong/x_pos: got 'far', "
            r'allowed is a finite number'):
        assert len(re.findall(line, node.output)) == 1, (line, node.output)
    wait_for(lambda: simulated(shared_ros) == ['tb3_0', 'tb3_10'], lambda: simulated(shared_ros))
    for name in ('/broken', '/use_sim_time'):
        shared_ros.set_parameters(name)


def test_a_given_prefix_of_frames_is_used_and_no_robot_takes_the_place_of_another(
        shared_ros, several):
    shared_ros.set_parameters('/a/tf_prefix', 'one')
    node = several({'a': {}, 'b': {'x_pos': 0.0, 'y_pos': 0.0}}, '_x_pos:=0.0', '_y_pos:=0.0',
                   '_world_tf:=true')
    node.wait_output('simulating 2 robots')
    node.wait_output('robot b is at the start: x 0.00 m, y 0.00 m')
    assert Messages(shared_ros, '/a/odom').wait_more(1)[0].header.frame_id == 'one/odom'
    transforms = Messages(shared_ros, '/tf_static').wait_more(1)[0].transforms
    assert ('world', 'one/odom') in {(each.header.frame_id, each.child_frame_id)
                                     for each in transforms}
    shared_ros.set_parameters('/a')


def test_robots_are_added_removed_and_changed_while_it_runs(shared_ros, several):
    services = ServiceCalls(shared_ros)
    node = several({'a': {'x_pos': 1.0}, 'b': {}})
    node.wait_output('simulating 2 robots')
    odometry = Messages(shared_ros, '/c/odom')
    shared_ros.set_parameters('/gazebo/robots', {
        'a': {'x_pos': 1.0}, 'c': {}, 'd': {'yaw': 'north'}})
    answer = services.call('/gazebo/update_robots', {})
    assert not answer['success']
    assert answer['message'].startswith("d: parameter /gazebo/robots/d/yaw: got 'north'")
    wait_for(lambda: simulated(shared_ros) == ['a', 'c'], lambda: simulated(shared_ros))
    assert odometry.wait_more(1)[0].header.frame_id == 'c/odom'
    node.wait_output('robot b was removed')
    shared_ros.set_parameters('/gazebo/robots', {'a': {'x_pos': 3.0}, 'c': {}})
    assert services.call('/gazebo/update_robots', {})['success']
    node.wait_output(r'(?s)robot a was removed.*robot a is at the start: x 3.00 m')
    assert len(re.findall('robot c was', node.output)) == 0
    shared_ros.set_parameters('/gazebo/robots', 4)
    assert 'got 4, wants a mapping of robots' in services.call(
        '/gazebo/update_robots', {})['message']
    assert simulated(shared_ros) == ['a', 'c']
    shared_ros.set_parameters('/gazebo/robots', {})
    assert services.call('/gazebo/update_robots', {})['success']
    wait_for(lambda: simulated(shared_ros) == [], lambda: simulated(shared_ros))
    services.close()
    assert node.interrupt() == 0


def test_a_list_that_cannot_be_read_ends_it_with_one_line(shared_ros):
    # that the demo ends with it is in the next test, and without respawn in the last one
    assert 'robots: cannot read /no/robots.yaml: ' in shared_ros.start_node(
        'robots.py', '_robots:=/no/robots.yaml').fatal_line()


def test_the_demo_ends_with_the_node():
    node, = (each for each in launch_config('demo.launch', 'robots:=1').nodes
             if each.name == 'robots')
    assert node.launch_prefix.endswith('/respawn.py --required') and node.respawn


# fails until the test says otherwise, and counts
SIMULATOR = '''
import rospy
from std_srvs.srv import Trigger, TriggerResponse
calls = []
def serve(_):
    calls.append(1)
    rospy.set_param('/calls', len(calls))
    return TriggerResponse(True, '') if rospy.has_param('/works') else 1 / 0
rospy.init_node('gazebo')
rospy.Service('~update_robots', Trigger, serve)
rospy.spin()
'''


def test_a_simulator_that_fails_is_asked_again_in_peace(shared_ros):
    simulator = shared_ros.start(sys.executable, '-c', SIMULATOR)
    node = shared_ros.start_node('robots.py', '_robots:=1', '_recognition:=false',
                                 '_teleop:=false', '_camera:=none')
    line = r'\[WARN\].*/gazebo/update_robots fails, and is called again: .*division by zero'
    wait_for(lambda: len(re.findall(line, node.output)) == 2, lambda: node.output)
    # in the 5 s between two lines there is a call each 0.5 s
    assert shared_ros.parameter('/calls') <= 12
    shared_ros.set_parameters('/works', True)
    node.wait_output('1 robots are running')
    assert node.interrupt() == 0 and simulator.interrupt() == 0
    shared_ros.set_parameters('/works')


LIST = '''\
- {name: a, x_pos: 1.0, colors: a.yaml}
- {name: a}
- {name: b, colors: none.yaml}
- {name: c, urdf: none.urdf}
'''


def test_the_nodes_of_each_robot_start_and_end_with_it(ros, tmp_path):
    path = tmp_path / 'robots.yaml'
    path.write_text(LIST)
    (tmp_path / 'a.yaml').write_text('min_blob_size: 77\nstop_when_lost: 0.7\n')
    # nothing moves: time may pass slowly
    demo = ros.demo('robots:={}'.format(path), 'camera:=none', 'world:=empty',
                    'real_time_factor:=0.2')
    demo.wait_output(r'process\[a/color_extract-\d\]: started')
    demo.wait_output('1 robots are running, 3 not started')
    for line in ('not started: robot 2 of the list: the name a is used',
                 'not started: b: cannot read the parameters in .*none.yaml: No such file',
                 'not started: c: cannot read the robot in .*none.urdf: No such file'):
        assert len(re.findall(line, demo.output)) == 1, (line, demo.output)
    services = ServiceCalls(ros)
    nodes = ['color_extract', 'robot_state_publisher', 'turtlebot3_teleop_keyboard']
    wait_for(lambda: running(ros, 'a') == ['/a/' + name for name in nodes],
             lambda: running(ros, 'a'))
    assert simulated(ros) == ['a']
    # one process for the nodes of all robots; it and the simulator have one that respawns them
    programs = [name for line in process_table.descendants(demo.pid).values()
                for name in ('roslaunch', 'respawn.py', 'robots.py')
                if any(word.endswith('/' + name) for word in line.split()[:2])]
    assert sorted(programs) == ['respawn.py', 'respawn.py', 'robots.py'], programs
    os.kill(ros.node_pid('/a/color_extract'), signal.SIGKILL)
    demo.wait_output(r'\[a/color_extract-\d+\] restarting process')
    demo.wait_output(r'(?s)restarting process.*process\[a/color_extract-\d+\]: started')
    assert ros.parameter('/a/color_extract/min_blob_size') == 77
    # the new file at the same path is silent about one of the values
    (tmp_path / 'a.yaml').write_text('stop_when_lost: 0.6\n')
    assert not services.call('/robots/reload', {})['success']       # b and c
    wait_for(lambda: ros.parameter('/a/color_extract/stop_when_lost') == 0.6,
             lambda: ros.parameter('/a/color_extract'))
    assert ros.parameter('/a/color_extract/min_blob_size') != 77
    wait_for(lambda: running(ros, 'a') == ['/a/' + name for name in nodes],
             lambda: running(ros, 'a'))
    path.write_text('- {name: d, recognition: false}\n- {name: a, x_pos: 1.0, colors: a.yaml}\n')
    assert services.call('/robots/reload', {}) == {'success': True, 'message': ''}
    wait_for(lambda: running(ros, 'd') == ['/d/' + name for name in nodes[1:]],
             lambda: running(ros, 'd'))
    path.write_text('- {name: d, recognition: false}\n- 3\n')
    answer = services.call('/robots/reload', {})
    assert answer == {'success': False, 'message':
                      'robot 2 of the list: got 3, expected a mapping with a name, like - name: '
                      'tb3_0'}
    wait_for(lambda: running(ros, 'a') == [] and simulated(ros) == ['d'],
             lambda: (running(ros, 'a'), simulated(ros)))
    assert not ros.parameter('/a') and ros.parameter('/d/robot_description')
    path.write_text('nothing: useful\n')
    assert 'got dict' in services.call('/robots/reload', {})['message']
    assert len(running(ros, 'd')) == 2
    services.close()
    assert demo.interrupt() == 0
    assert 'escalating' not in demo.output and 'symlink' not in demo.output
    assert demo.output.count('shutting down processing monitor...') <= 1


def test_the_nodes_of_real_robots_stop_them_and_end_when_the_node_that_runs_them_is_killed(ros):
    demo = ros.demo('robots:=1', 'simulator:=false', 'safe:=true', 'camera:=none',
                    'respawn:=false')
    demo.wait_output('1 robots are running')
    nodes = ['/tb3_0/color_extract', '/tb3_0/turtlebot3_teleop_keyboard']
    wait_for(lambda: running(ros, 'tb3_0') == nodes, lambda: running(ros, 'tb3_0'))
    # when the camera is lost
    assert ros.parameter('/tb3_0/color_extract/stop_when_lost') == 0.5
    pid = int(re.search(r'process\[robots-\d+\]: started with pid \[(\d+)\]',
                        demo.output).group(1))
    os.kill(pid, signal.SIGKILL)
    # it is required: the demo ends, and nothing is left over
    assert demo.wait() == 0
    pids = re.findall(r'process\[tb3_0/.*\]: started with pid \[(\d+)\]', demo.output)
    assert len(pids) == 2
    wait_for(lambda: not any(os.path.exists('/proc/' + pid) for pid in pids),
             'the end of the nodes')
