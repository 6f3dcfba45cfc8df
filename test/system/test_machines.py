"""machines.launch: which part is on which machine, and all of them on this one."""
from img_recog_helpers.launch_config import launch_config


def loaded(*arguments):
    """Return the nodes and the parameters that the launch file gives."""
    config = launch_config('machines.launch', *arguments)
    return config.nodes, {name: param.value for name, param in config.params.items()
                          if name in ('/use_sim_time', '/color_extract/stop_when_lost')}


def test_each_part_is_on_its_machine():
    nodes, parameters = loaded(
        'simulator_host:=192.0.2.1', 'camera_host:=192.0.2.2', 'recognition_host:=192.0.2.3',
        'env_loader:=/there/env.sh', 'user:=pi')
    assert {node.name: node.machine.address for node in nodes} == {
        'gazebo': '192.0.2.1', 'robot_state_publisher': '192.0.2.1',
        'turtlebot3_teleop_keyboard': '192.0.2.1', 'usb_cam': '192.0.2.2',
        'color_extract': '192.0.2.3'}
    assert {node.machine.env_loader for node in nodes} == {'/there/env.sh'}
    assert parameters == {'/use_sim_time': True, '/color_extract/stop_when_lost': 0.0}


def test_a_real_robot_needs_no_simulator_and_is_stopped():
    nodes, parameters = loaded('simulator:=false', 'camera_host:=192.0.2.2')
    assert [node.name for node in nodes] == ['turtlebot3_teleop_keyboard', 'usb_cam',
                                             'color_extract']
    assert parameters == {'/use_sim_time': False, '/color_extract/stop_when_lost': 0.5}


def test_without_respawn_the_nodes_are_started_as_they_are():
    def started(*arguments):
        return {node.name: (node.package, node.type, node.args.split())
                for node in loaded(*arguments)[0]}
    nodes, _ = loaded('respawn:=false')
    assert not [node.name for node in nodes if node.launch_prefix or node.respawn]
    assert [node.name for node in nodes if node.required] == ['gazebo', 'color_extract']
    # so it drives if it does with respawn
    assert started('respawn:=false') == started()


def test_on_this_machine_it_drives(ros):
    demo = ros.roslaunch('img_recog', 'machines.launch', 'camera:=synthetic', 'world:=empty',
                         'image_width:=320', 'image_height:=240')
    demo.wait_output('(?s)the robot drives forward.*the robot stands')
    assert demo.interrupt() == 0
