"""machines.launch: which part is on which machine, and all of them on this one."""
import json
import sys

import pytest

LOAD = '''
import json, sys
from roslaunch.config import load_config_default
from rospkg import RosPack
path = RosPack().get_path('img_recog') + '/launch/machines.launch'
config = load_config_default([(path, sys.argv[1:])], None, assign_machines=True)
print(json.dumps([[node.name, node.machine.address, node.machine.env_loader]
                  for node in config.nodes]))
print(json.dumps({name: param.value for name, param in config.params.items()
                  if name in ('/use_sim_time', '/color_extract/stop_when_lost')}))
'''


def loaded(ros, *arguments):
    """Return the addresses of the nodes and the parameters that the launch file gives."""
    output = ros.run(sys.executable, '-c', LOAD, *arguments)
    nodes, parameters = [json.loads(line) for line in output.splitlines()[-2:]]
    return nodes, parameters


def test_each_part_is_on_its_machine(ros):
    nodes, parameters = loaded(
        ros, 'simulator_host:=192.0.2.1', 'camera_host:=192.0.2.2', 'recognition_host:=192.0.2.3',
        'env_loader:=/there/env.sh', 'user:=pi')
    assert {name: address for name, address, _ in nodes} == {
        'gazebo': '192.0.2.1', 'robot_state_publisher': '192.0.2.1',
        'turtlebot3_teleop_keyboard': '192.0.2.1', 'usb_cam': '192.0.2.2',
        'color_extract': '192.0.2.3'}
    assert {loader for _, _, loader in nodes} == {'/there/env.sh'}
    assert parameters == {'/use_sim_time': True, '/color_extract/stop_when_lost': 0.0}


def test_a_real_robot_needs_no_simulator_and_is_stopped(ros):
    nodes, parameters = loaded(ros, 'simulator:=false', 'camera_host:=192.0.2.2')
    assert [name for name, _, _ in nodes] == ['turtlebot3_teleop_keyboard', 'usb_cam',
                                              'color_extract']
    assert parameters == {'/use_sim_time': False, '/color_extract/stop_when_lost': 0.5}


@pytest.mark.parametrize('respawn', ['true', 'false'])
def test_on_this_machine_it_drives(ros, respawn):
    demo = ros.roslaunch('img_recog', 'machines.launch', 'camera:=synthetic',
                         'respawn:=' + respawn)
    demo.wait_output('(?s)the robot drives forward.*the robot stands')
    assert demo.interrupt() == 0
