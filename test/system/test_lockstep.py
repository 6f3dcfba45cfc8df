"""Simulated time waits for the answers of nodes: the same path in each run, whatever happens."""
import os
import re
import signal

import pytest

from img_recog_helpers.lockstep import CAMERA, compiled, controller, driver, path, paths_of_two
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import Echo, burger, complaints, drawing
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


def test_the_path_does_not_depend_on_speed_language_buffers_and_killed_programs(ros, tmp_path):
    fast, started = '_real_time_factor:=0', []

    def start_driver(ros):
        started.append(driver(ros, delay='0.1 * numpy.random.random()', buffer_bits=16,
                              topic='found'))
        return started[-1]

    def start_controller(ros):
        started.append(controller(ros))
        return started[-1]

    def chain(ros):
        start_controller(ros)
        return start_driver(ros)

    def kill_each(node, process, rows):
        wait_for(lambda: len(rows) > 10, lambda: node.output)
        os.kill(drawing(node), signal.SIGKILL)
        first_controller, first_driver = started
        for killed, start_again, count in ((first_driver, start_driver, 20),
                                           (first_controller, start_controller, 25)):
            wait_for(lambda count=count: len(rows) > count, lambda: node.output)
            killed.send_signal(signal.SIGKILL)
            killed.wait()
            start_again(ros)

    first = path(ros, fast)
    assert path(ros, '_real_time_factor:=1', start=chain, disturb=kill_each) == first
    for process in started[2:]:
        process.close()
    program = compiled(tmp_path)
    if program is None:
        pytest.skip('no compiler or headers for a node in C++')
    assert path(ros, fast, start=lambda ros: ros.start(program)) == first


def test_the_paths_of_two_robots_do_not_depend_on_who_answers_first(ros):
    first = paths_of_two(ros, '0', '0.02')
    assert first[0] != first[1] and paths_of_two(ros, '0.02', '0') == first


def test_what_does_not_answer_or_answers_twice_is_named_once(simulate, ros):
    node = simulate(*CAMERA, '_lockstep:=cmd_vel /other', '_lockstep_timeout:=0.5')
    process, clock = driver(ros, count=2), Echo(ros, '/clock')
    node.wait_output('simulation paused: waiting for a publisher of /other')
    assert {row[0] for row in clock.rows} <= {0}
    other = ros.start('rostopic', 'pub', '/other', 'std_msgs/Header', '{}')
    node.wait_output(r'no answer in 0.5 s to what was measured at 0.033 s: the last message on '
                     r'/other, of /rostopic\S*, has the stamp 0.000 s')
    node.wait_output('lockstep: /driver publishes more than one message on /cmd_vel')
    clock.wait(lambda time: time > 1e9, 'time that goes on')
    second = driver(ros, 'second')
    node.wait_output('lockstep: /driver, /second publish on /cmd_vel')
    assert len(re.findall('no answer', node.output)) == 1
    for each in (other, process, second):
        each.close()


def test_the_simulator_ends_if_it_is_told_to(simulate, ros):
    node = simulate(*CAMERA, '_lockstep:=answer', '_lockstep_timeout:=0.2',
                    '_lockstep_at_timeout:=end')
    other = ros.start('rostopic', 'pub', '/answer', 'geometry_msgs/Twist', '{}')
    echo = Echo(ros, '/image_raw/header')
    line = node.fatal_line()
    assert 'the last message on /answer' in line and 'set lockstep_timeout higher' in line
    other.close()
    echo.close()


def test_a_robot_without_the_sensor_is_refused(simulate):
    line = simulate('_lockstep:=cmd_vel').fatal_line()
    assert 'waits for answers to image, but the robot has no such sensor' in line
    assert 'start with camera:=robot, or set lockstep_sensors to some of scan, odom' in line


def test_time_by_hand(simulate, ros):
    master, states = ros.master(), []

    def is_found():
        for _ in range(1000):       # without a pause, to see the moment when it comes
            states.append(master.getSystemState('/test')[2])
            if '/gazebo/step' in dict(states[-1][2]):
                return True

    node = simulate('_paused:=true')
    wait_for(is_found, 'the service ~step')
    # who finds the service finds the sensors
    assert {'/odom', '/scan'} <= set(dict(states[-1][0]))
    node.wait_output('is at the start')
    clock, scan = Echo(ros, '/clock'), Echo(ros, '/scan/header/stamp')
    wait_for(lambda: clock.is_connected.is_set() and scan.is_connected.is_set(), 'connections')
    services = ServiceCalls(ros)

    def told():
        return services.call('/gazebo/step', {})['message']
    answer = services.call('/gazebo/step', {})
    assert answer['success'] and 'simulated time is 0.033 s' in answer['message']
    assert [row[0] for row in clock.rows] == [1e7, 2e7, 3e7, 3.3e7]
    ros.set_parameters('/gazebo/step_period', 0.467)
    assert 'simulated time is 0.500 s' in told()
    wait_for(lambda: scan.rows == [[2e8], [4e8]], lambda: scan.rows)
    ros.set_parameters('/gazebo/step_period', 0.0105)
    assert 'does not divide into physics steps' in told()
    ros.set_parameters('/gazebo/step_period', 3600.0)
    step = ros.start('rosservice', 'call', '/gazebo/step')
    clock.wait(lambda time: time > 1e9, 'time that goes on')
    services.call('/gazebo/reset_simulation', {})
    step.wait_output('simulated time is 0.000 s')
    services.call('/gazebo/unpause_physics', {})
    clock.wait(lambda time: time > 1e9, 'time that goes on')
    assert 'the physics is not paused' in told()
    services.close()
    assert complaints(node) == []


def test_images_come_from_the_start(simulate, ros):
    node = simulate(*CAMERA, '_paused:=true', '_real_time_factor:=0', urdf=burger())
    images = Echo(ros, '/image_raw/header/stamp')
    node.wait_output('is at the start')
    wait_for(images.is_connected.is_set, 'a connection')
    services = ServiceCalls(ros)
    services.call('/gazebo/unpause_physics', {})
    assert images.wait_more(1)[0] == [33e6]
    services.call('/gazebo/pause_physics', {})      # as fast as possible is not needed any more
    services.close()
