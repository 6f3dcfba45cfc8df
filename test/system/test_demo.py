"""The demo as a user runs it: start it, use ROS tools on it, stop it, kill nodes of it."""
import os
import re
import signal

import pytest
import rosbag

from img_recog.processes.bag_recording import TOPICS
from img_recog_helpers import wire
from img_recog_helpers.process_table import is_alive
from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.waiting import wait_for

NODES = ('color_extract', 'gazebo', 'robot_state_publisher', 'turtlebot3_teleop_keyboard',
         'usb_cam')
DRAWN = r'\.png: \d+\.\d s, [1-9]\d* poses, [1-9]\d* commands\n'
SELDOM_RECORDED = {'/tf_static', '/diagnostics', '/scan'}
NAMESPACED = '''<launch><include file="$(find img_recog)/launch/demo.launch" ns="lab">
  <arg name="camera" value="robot"/><arg name="world" value="color_posts"/>
  <arg name="framerate" value="10"/><arg name="web" value="false"/>
  <arg name="teleop" value="false"/>
  <arg name="record" value="{}/lab"/><arg name="robots" value="{}"/></include></launch>'''


def test_log_and_names_are_as_expected_and_ctrl_c_ends_everything(ros, tmp_path):
    demo = ros.demo('world:=empty')
    demo.wait_output(r'camera: synthetic scene, 320x240, 30 Hz')
    demo.wait_output(r'drives forward')
    pids = {name: ros.node_pid('/' + name) for name in NODES}
    # a connection that is just being made is an error for it
    ros.wait_run(r'(?s)\A(?!.*(Found \d+ error|\bERROR\b)).*running graph rules', 'roswtf')
    doctor = ros.start('rosrun', 'img_recog', 'doctor.py', env=dict(ros.env, LC_ALL='C.UTF-8'))
    # what the simulator takes under its own name, and nobody uses here, is no note either
    assert doctor.wait() == 0 and 'problem: ' not in doctor.output, doctor.output
    assert '/gazebo/' not in doctor.output, doctor.output
    plot = ros.start_node('plot.py', str(tmp_path / 'live.png'), '--duration', '2')
    assert plot.wait() == 0 and re.search('live' + DRAWN, plot.output), plot.output
    plot = ros.start_node('plot.py', str(tmp_path / 'no.png'), '--robot', 'tb3_1')
    assert plot.wait() == 1
    assert 'has no odometry on /tb3_1/odom; there is /odom; choose a robot' in plot.output
    # the whole scene, in which the tools have run
    demo.wait_output(r'(?s)blue=[1-9]\d{3}, red=0\n.*drives forward.*blue=0, red=0\n.*stands.*'
                     r'blue=0, red=[1-9]\d{3}\n.*drives backward.*blue=0, red=0\n.*stands')
    assert demo.interrupt() == 0
    for words in ('Traceback', 'has died', 'escalating', '[ERROR]', '[FATAL]'):
        assert words not in demo.output, demo.output
    assert [name for name, pid in pids.items() if is_alive(pid)] == []


def test_auto_logs_which_camera_it_uses(ros):
    ros.start_core()
    camera = ros.start_node('usb_cam_node.py', '_video_device:=auto')
    expected = 'V4L2 device /dev/video0|/dev/video0' if os.path.exists('/dev/video0') else \
        'synthetic scene'
    camera.wait_output('camera: ({})|cannot open ({})'.format(expected, expected))


def test_the_camera_of_the_robot_gets_its_parameters_from_the_launch_file(ros):
    arguments = ['roslaunch', '--dump-params', 'img_recog', 'demo.launch']
    demo = ros.start(*arguments, 'camera:=robot', 'image_width:=320', 'framerate:=15')
    demo.wait()
    lines = demo.output.splitlines()
    for name, value in (('frame', 'camera_link'), ('optical_frame', 'head_camera'),
                        ('image_topic', 'usb_cam/image_raw'),
                        ('info_topic', 'usb_cam/camera_info'), ('width', '320'),
                        ('height', '480'), ('rate', '15')):
        assert '/gazebo/camera_{}: {}'.format(name, value) in lines, demo.output
    assert 'WARN' not in demo.output        # about what roslaunch ignores
    synthetic = ros.start(*arguments)
    synthetic.wait()
    assert '/gazebo/world' in synthetic.output and '/gazebo/camera' not in synthetic.output


def wait_recorded(ros, recorder, world, robot):
    """Wait until a node records all topics; world, robot: the namespaces of what is not global."""
    names = [topic if topic.startswith('/') else
             (world if topic.startswith('gazebo/') else robot) + topic
             for topic in set(TOPICS) - SELDOM_RECORDED - {'scan'}]
    ros.node_pid(recorder)
    uri = wire.node_uri(ros.master_uri, recorder)

    def missing():
        return set(names) - {connection[4] for connection in wire.call(uri, 'getBusInfo')}
    wait_for(lambda: not missing(), missing)


def test_a_recording_has_what_is_worth_keeping(ros, tmp_path):
    """And a film and a picture can be made of it."""
    # of each image, the film has a frame; as many zeros of the teleop leave the robot standing
    demo = ros.demo('world:=empty', 'record:={}/demo'.format(tmp_path), 'framerate:=5',
                    'teleop:=false')
    demo.wait_output('the robot drives forward')
    wait_recorded(ros, '/record', '/', '/')
    commands = Echo(ros, '/cmd_vel')
    Echo(ros, '/usb_cam/camera_info/header/stamp').wait_more(10)
    commands.wait_more(2)
    assert demo.interrupt() == 0
    path = str(tmp_path / 'demo.bag')
    with rosbag.Bag(path) as bag:
        recorded = set(bag.get_type_and_topic_info().topics)
    missing = {'/' + name.lstrip('/') for name in TOPICS} - recorded
    assert missing <= SELDOM_RECORDED
    plot = ros.start_node('plot.py', path, str(tmp_path / 'bag.png'))
    assert plot.wait() == 0 and re.search('bag' + DRAWN, plot.output), plot.output
    film = ros.start_node('film.py', path, str(tmp_path / 'film.mp4'))
    assert film.wait() == 0, film.output
    assert re.search(r'film.mp4: \d+\.\d s, \d+ images of /usb_cam/image_raw/compressed',
                     film.output), film.output


@pytest.mark.parametrize('robots, robot', [('none', '/lab/'), ('2', '/lab/tb3_1/')])
def test_in_a_namespace_it_is_the_same_on_the_one_clock(ros, tmp_path, robots, robot):
    path = tmp_path / 'included.launch'
    path.write_text(NAMESPACED.format(tmp_path, robots))
    demo = ros.roslaunch(path)
    demo.wait_output('(the robot|robot tb3_1) drives forward')
    wait_recorded(ros, '/lab/record', '/lab/', robot)
    published, subscribed, _ = ros.master().getSystemState('/test')[2]
    topics = {name for name, _ in published + subscribed}
    assert {name for name in topics if name.startswith('/lab/')} >= {
        robot + name for name in ('usb_cam/image_raw', 'blue_image', 'cmd_vel', 'odom', 'scan')}
    assert {name for name in topics if not name.startswith('/lab/')} == {
        '/clock', '/diagnostics', '/rosout', '/rosout_agg', '/tf', '/tf_static'}
    # among others, that no node stamps by another clock
    doctor = ros.start('rosrun', 'img_recog', 'doctor.py')
    assert doctor.wait() == 0 and 'problem: ' not in doctor.output, doctor.output
    ros.run('rosservice', 'call', '/lab/gazebo/reset_world')
    demo.wait_output('at the start')
    begin = len(demo.output)
    pid = ros.node_pid('/lab/gazebo')
    os.kill(pid, signal.SIGKILL)
    wait_for(lambda: re.search(r'(?s)gazebo: killed by SIGKILL, started again.* drives forward',
                               demo.output[begin:]), lambda: demo.output[begin:])
    assert demo.interrupt() == 0
    for words in ('Traceback', 'escalating', '[ERROR]', '[FATAL]'):
        assert words not in demo.output, demo.output
