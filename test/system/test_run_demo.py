"""./run demo: it ends within seconds, leaves no process behind, and prints why it ended."""
import contextlib
import fcntl
import os
import re
import select
import signal
import subprocess
import urllib.parse

import psutil
import pytest

from img_recog_helpers import process_table
from img_recog_helpers.pages import ROOT, read
from img_recog_helpers.process_table import end_all, is_alive, marked, ports
from img_recog_helpers.processes import SMALL_CAMERA, Ros
from img_recog_helpers.waiting import wait_for

END_S = 10.0
# so that also on a busy machine the nodes end by themselves, before the supervisor kills them
PATIENT = {'IMG_RECOG_END_SCALE': '10'}
PROBLEMS = re.compile(r'Traceback|has died|escalating|\[ERROR\]|\[FATAL\]|has ended')
NODES = ('rosout', 'robot_state_publisher', 'gazebo', 'color_extract', 'usb_cam',
         'turtlebot3_teleop_keyboard')
# the demo with one node, the teleop, for tests that look only at how it ends
SMALL = 'simulator:=false', 'camera:=none', 'recognition:=false'
STARTED = 'no terminal to read keys from'
F_SETPIPE_SZ, PIPE_BYTES = 1031, 4096       # fcntl.h of Linux


@pytest.fixture
def run_demo(ros):
    """A function that starts ./run demo; `mark` of it is in the environment of all processes."""
    env = dict(ros.env)
    del env['ROS_HOSTNAME']         # ./run sets it

    def start(*arguments, **popen):
        return ros.start(os.path.join(ROOT, 'run'), 'demo', *arguments, 'web:=false',
                         start_new_session=True,
                         env=env, **popen)
    start.env = env
    start.mark = ros.marker
    yield start
    end_all(ros.marker)


@pytest.mark.parametrize('signum, moment', [
    (signal.SIGINT, 'bash'), (signal.SIGINT, 'roslaunch'), (signal.SIGINT, 'rosmaster'),
    (signal.SIGINT, 'teleop_key'), (signal.SIGTERM, 'usb_cam'), (signal.SIGHUP, 'roslaunch')])
def test_signal_at_any_moment_ends_everything(run_demo, moment, signum):
    """moment: when this program runs."""
    demo = run_demo(*SMALL_CAMERA)
    wait_for(lambda: any(moment in line for line in marked(run_demo.mark).values()),
             lambda: '{} in:\n{}'.format(moment, demo.output))
    send = os.killpg if signum == signal.SIGINT else os.kill       # a terminal sends it to all
    send(demo.pid, signum)
    wait_for(lambda: not marked(run_demo.mark),
             lambda: 'the end of {} in:\n{}'.format(marked(run_demo.mark), demo.output), END_S)
    assert demo.wait() == (-signum if moment == 'bash' else 0), demo.output


@pytest.mark.parametrize('words', [r'starting; press Ctrl-C', 'started roslaunch server', STARTED])
def test_ctrl_c_gives_the_same_exit_code_at_any_moment_of_the_start(run_demo, words):
    demo = run_demo(*SMALL)
    demo.wait_output(words)
    assert interrupt(demo) == 0
    # rosmaster itself prints one
    assert 'Traceback' not in demo.output.partition('started roslaunch server')[0]


def test_ctrl_c_is_not_lost_in_a_program_that_ends_normally(run_demo, tmp_path):
    # like a Python that is about to end when the signal comes
    program, is_started = tmp_path / 'bin' / 'mkdir', tmp_path / 'started'
    program.parent.mkdir()
    # what it leaves behind, does not hold the output of the demo
    program.write_text('#!/bin/bash\ntrap "exit 0" INT\ntouch {}\n'
                       'sleep 1000 >/dev/null 2>&1 & wait\n'.format(is_started))
    program.chmod(0o755)
    run_demo.env['PATH'] = '{}:{}'.format(program.parent, run_demo.env['PATH'])
    demo = run_demo(*SMALL_CAMERA)
    wait_for(is_started.exists, 'the program')
    os.killpg(demo.pid, signal.SIGINT)
    assert demo.wait() == -signal.SIGINT
    assert 'process[' not in demo.output


@pytest.mark.parametrize('moment', ['setup', STARTED])
def test_ctrl_c_ends_what_a_script_has_started_in_the_background(run_demo, ros, tmp_path, moment):
    if moment == 'setup':
        program = tmp_path / 'bin' / 'mkdir'
        program.parent.mkdir()
        program.write_text('#!/bin/sh\necho setup\nexec sleep 1000\n')
        program.chmod(0o755)
        run_demo.env['PATH'] = '{}:{}'.format(program.parent, run_demo.env['PATH'])
    # bash starts it with SIGINT ignored
    script = ros.start('bash', '-c', '{}/run demo {} web:=false & echo pid $!; wait'.format(
        ROOT, ' '.join(SMALL)), env=run_demo.env, start_new_session=True)
    script.wait_output(moment)
    pid = int(script.wait_output(r'pid (\d+)\n').group(1))
    for each in [*process_table.descendants(pid), pid] if moment == 'setup' else [pid]:
        with contextlib.suppress(ProcessLookupError):       # it has ended by itself meanwhile
            os.kill(each, signal.SIGINT)
    wait_for(lambda: not marked(run_demo.mark), lambda: 'the end of:\n' + script.output, END_S)


def test_ctrl_c_while_nodes_are_started_is_no_error(run_demo, tmp_path):
    # roslaunch ends with 1 if it was about to start another node
    program = tmp_path / 'bin' / 'roslaunch'
    program.parent.mkdir()
    program.write_text('#!/bin/bash\ntrap "exit 1" INT\necho "started roslaunch server"\n'
                       'echo "process[master]: started with pid [1]"\nsleep 1000 & wait\n')
    program.chmod(0o755)
    run_demo.env['PATH'] = '{}:{}'.format(program.parent, run_demo.env['PATH'])
    demo = run_demo(*SMALL_CAMERA)
    demo.wait_output(r'process\[master.*started')
    assert interrupt(demo) == 0


def test_roslaunch_stuck_in_its_own_locks_is_killed(run_demo):
    demo = run_demo(*SMALL)
    demo.wait_output(STARTED)
    # like a roslaunch that was interrupted while it started a node, it ignores signals
    roslaunch = psutil.Process(node(demo, 'turtlebot3_teleop_keyboard')).ppid()
    os.kill(roslaunch, signal.SIGSTOP)
    os.killpg(demo.pid, signal.SIGINT)
    wait_for(lambda: not marked(run_demo.mark), lambda: 'the end of:\n' + demo.output, END_S)


def test_roslaunch_ends_when_its_supervisor_is_killed(run_demo):
    demo = run_demo(*SMALL)
    demo.wait_output(STARTED)
    os.kill(demo.pid, signal.SIGKILL)
    wait_for(lambda: not marked(run_demo.mark), lambda: 'the end of:\n' + demo.output)


@pytest.mark.parametrize('blocking, signum', [(True, signal.SIGQUIT), (False, signal.SIGINT)])
def test_output_that_nobody_reads_does_not_keep_it_from_ending(run_demo, blocking, signum):
    reader, writer = os.pipe()
    fcntl.fcntl(writer, F_SETPIPE_SZ, PIPE_BYTES)
    os.set_blocking(writer, blocking)
    try:
        demo = subprocess.Popen(
            [os.path.join(ROOT, 'run'), 'demo', *SMALL, 'web:=false'], env=run_demo.env,
            stdin=subprocess.DEVNULL, stdout=writer, stderr=writer, start_new_session=True)
        wait_for(lambda: not select.select([], [writer], [], 0)[1], 'a full pipe')
        wait_for(lambda: any('teleop_key' in line for line in marked(run_demo.mark).values()),
                 'the teleop')
        os.kill(demo.pid, signum)
        wait_for(lambda: not marked(run_demo.mark),
                 lambda: 'the end of {}'.format(marked(run_demo.mark)), END_S)
        demo.wait()
    finally:
        os.close(reader)
        os.close(writer)


def xml_rpc_port(ros, name):
    master = ros.master()
    uri = wait_for(lambda: master.lookupNode('/test', name)[2], 'the node ' + name)
    return urllib.parse.urlparse(uri).port


def interrupt(demo):
    """Press Ctrl-C; return the exit code."""
    os.killpg(demo.pid, signal.SIGINT)
    wait_for(lambda: not demo.is_running(), lambda: 'the end of:\n' + demo.output, END_S)
    return demo.wait()


def test_a_running_demo_is_closed_to_other_machines_and_nodes_that_were_killed_come_back(
        run_demo, ros):
    run_demo.env.update(PATIENT)
    demo = run_demo(*SMALL_CAMERA)
    demo.wait_output('the robot drives forward')
    # roscpp opens its XML-RPC port on all addresses, see doc/security.md
    known = {('tcp', xml_rpc_port(ros, name)) for name in ('/rosout', '/robot_state_publisher')}
    # the teleop may start later than the robot
    wait_for(lambda: len(ports(marked(run_demo.mark), 'tcp').all) >= 2 * len(NODES), 'all ports')
    assert ports(marked(run_demo.mark)).open_to_others == known
    assert not PROBLEMS.search(demo.output), demo.output
    # the process that roslaunch knows, and the node below it
    os.kill(node(demo, 'color_extract'), signal.SIGKILL)
    demo.wait_output(r'\[color_extract-\d+\] restarting process')
    simulator, = psutil.Process(node(demo, 'gazebo')).children()
    simulator.kill()
    demo.wait_output(r'(?s)gazebo: killed by SIGKILL, started again.*the robot is at the start: '
                     r'x -2.00 m, y -0.50 m.*the robot drives')
    os.kill(node(demo, 'robot_state_publisher'), signal.SIGKILL)    # it has no respawn.py
    demo.wait_output(r'(?s)\[robot_state_publisher-\d+\] restarting process.*'
                     r'process\[robot_state_publisher-\d+\]: started')
    # before, a node that is started again late may be reported
    before = len(demo.output)
    assert interrupt(demo) == 0
    assert not PROBLEMS.search(demo.output, before), demo.output


def node(demo, name):
    return int(demo.wait_output(r'process\[{}-\d+\]: started with pid \[(\d+)\]'.format(
        name)).group(1))


def last_line(demo):
    return demo.output.rstrip().splitlines()[-1]


@pytest.mark.parametrize('argument, content, node, part, reason', [
    ('framerate', '0', 'usb_cam', 'the camera', '/usb_cam/framerate: got 0.0, allowed is '),
    ('camera', __file__, 'usb_cam', 'the camera', 'cannot play .*; give one, or synthetic'),
    ('urdf', '<sdf/>', 'gazebo', 'the simulator', 'root element <sdf>'),
    # the node itself has this topic
    ('colors', 'red_image_topic: cmd_vel\n', 'color_extract', 'the recognition',
     'red_image_topic')])
def test_a_part_that_is_needed_or_refuses_its_parameters_ends_the_demo(
        run_demo, tmp_path, argument, content, node, part, reason):
    path = tmp_path / 'file'
    path.write_text(content)
    # no other part but that
    others = {'usb_cam': ['recognition:=false', 'simulator:=false'],
              'gazebo': ['recognition:=false', 'camera:=none'],
              'color_extract': ['camera:=none', 'simulator:=false']}[node]
    demo = run_demo('teleop:=false', 'world:=empty', *others, '{}:={}'.format(
        argument, content if node == 'usb_cam' else path))
    assert demo.wait() == 1
    assert re.match(r'\[run\] {} \({}\) has ended: .*{}'.format(part, node, reason),
                    last_line(demo)), demo.output
    assert re.search(r'\[respawn\] {}: ended, and the demo with it: .*{}'.format(node, reason),
                     demo.output), demo.output


@pytest.mark.parametrize('word, name', [('camera:=robot', 'camera_robot'),
                                        ('lockstep:=cmd_vel', 'lockstep')])
def test_what_roslaunch_refuses_is_said_again(run_demo, word, name):
    demo = run_demo(word, 'simulator:=false')
    assert demo.wait() == 1
    assert last_line(demo) == ("[run] roslaunch has ended: RLException: arg '{}_needs_simulator_"
                               "true' is not defined.".format(name)), demo.output
    assert 'process[' not in demo.output


def test_a_given_master_of_another_demo_is_refused(run_demo, ros):
    run_demo.env['ROS_NAMESPACE'] = '/lab/'
    first = run_demo(*SMALL)
    first.wait_output(STARTED)
    second = run_demo(*SMALL_CAMERA)
    assert second.wait() == 1
    assert last_line(second).startswith(
        '[run] the master {} has /lab/turtlebot3_teleop_keyboard of another demo, which this one '
        'would end; stop '.format(ros.master_uri)), second.output
    assert first.is_running()
    others = run_demo('simulator:=false', 'teleop:=false', 'camera:=none', 'use_sim_time:=true')
    others.wait_output(r'process\[\S*color_extract-\d+\]: started')
    assert interrupt(others) == 0 and first.is_running()


def test_a_demo_without_a_page_says_what_to_do_with_it(run_demo):
    demo = run_demo(*SMALL)
    demo.wait_output(STARTED)
    demo.wait_output(r'process\[turtlebot3(?s:.*)\[run\] the ROS tools work in ./run shell.*\n'
                     r'\[run\] Ctrl-C stops the demo\n')
    assert 'PARAMETERS' not in demo.output
    assert interrupt(demo) == 0


def test_nodes_say_what_they_wait_for(run_demo):
    demo = run_demo('simulator:=false', 'camera:=none', 'use_sim_time:=true', 'teleop:=false')
    demo.wait_output(r'\[WARN\] .*no image on /usb_cam/image_raw yet: start a camera')
    demo.wait_output(r'\[WARN\] .*no time on /clock yet: start the simulator')
    assert interrupt(demo) == 0


@pytest.mark.parametrize('uri, words', [
    ('http://192.0.2.1:11311', 'no master answers at http://192.0.2.1:11311, which is not this'),
    ('http://no.such.host.invalid:1', 'no master answers at http://no.such.host.invalid:1,'),
    ('http://localhost', 'got http://localhost, allowed is http://HOST:PORT'),
    ('localhost:11311', 'got localhost:11311, allowed is http://HOST:PORT'),
    ('http://localhost:x', 'got http://localhost:x, allowed is http://HOST:PORT'),
    ('http://:11311', 'got http://:11311, allowed is http://HOST:PORT')])
def test_a_master_that_cannot_be_is_refused(run_demo, uri, words):
    run_demo.env['ROS_MASTER_URI'] = uri
    demo = run_demo(*SMALL)
    assert demo.wait() == 1
    assert last_line(demo).startswith('[run] ROS_MASTER_URI: ' + words), demo.output
    assert 'unset ROS_MASTER_URI' in last_line(demo)
    assert 'Traceback' not in demo.output and 'process[' not in demo.output


def test_without_the_x_server_of_display_the_page_comes_in_place_of_windows(run_demo, ros):
    run_demo.env['DISPLAY'] = ':4711'
    demo = ros.start(os.path.join(ROOT, 'run'), 'demo', 'simulator:=false', *SMALL_CAMERA,
                     start_new_session=True, env=run_demo.env)
    demo.wait_output(r'\[run\] no X server can be used at DISPLAY=:4711: no windows, but the page')
    demo.wait_output(r'the page: http://.*\n(?s:.*)\[run\] the ROS tools work in ./run shell.*\n'
                     r'\[run\] Ctrl-C stops the demo\n')
    assert 'process[image_view' not in demo.output and 'PARAMETERS' not in demo.output
    assert interrupt(demo) == 0


def test_a_killed_master_is_reported_and_ends_the_demo(run_demo):
    demo = run_demo(*SMALL)
    demo.wait_output(STARTED)
    master, = [pid for pid, line in marked(run_demo.mark).items() if 'rosmaster' in line]
    os.kill(master, signal.SIGKILL)
    assert demo.wait() == 1
    assert last_line(demo) == '[run] the ROS master (master) has ended: killed by SIGKILL'


def test_camera_that_cannot_start_is_reported_and_the_other_nodes_continue(run_demo, ros):
    run_demo.env.update(PATIENT)
    demo = run_demo('camera:=http://127.0.0.1:1/video', 'simulator:=false')
    reason = r'\[run\] the camera \(usb_cam\) has ended: .*127.0.0.1'
    demo.wait_output(reason + '.*; the other nodes continue\n')
    demo.wait_output(r'\[respawn\] usb_cam: ended and is not started again: .*127.0.0.1')
    for name in ('color_extract', 'turtlebot3_teleop_keyboard'):
        assert ros.node_pid('/' + name)
    assert interrupt(demo) == 0
    assert re.match(reason, last_line(demo)), demo.output


def test_a_killed_node_is_reported_and_the_robot_stops(run_demo, ros):
    demo = run_demo(*SMALL_CAMERA, 'respawn:=false')
    demo.wait_output('the robot drives forward')
    pids = {name: ros.node_pid('/' + name) for name in NODES}
    os.kill(pids['usb_cam'], signal.SIGKILL)
    demo.wait_output(r'\[run\] the camera \(usb_cam\) has ended: killed by SIGKILL; the other')
    wait_for(lambda: demo.output.rfind('the robot stands') > demo.output.rfind('drives'),
             lambda: 'the robot to stand in:\n' + demo.output)
    assert [name for name, pid in pids.items() if not is_alive(pid)] == ['usb_cam']


SPECIAL = str.maketrans({'[': r'\[', ']': r'\]'})


@pytest.mark.parametrize('page', ['README.md', 'README.ja.md'])
def test_the_readme_shows_the_log_of_a_real_run(request, page):
    lines = re.findall(r'(?m)^    (\[INFO\] .*)', read(page))
    assert len(lines) == 6
    output = request.getfixturevalue('output_of_a_demo')
    for line in lines:
        # times, areas and positions differ
        shape = re.sub(r'-?\d[\d.]+', lambda _: r'-?[\d.]{4,}', line.translate(SPECIAL))
        found = re.search('(?m)^{}$'.format(shape), output)
        assert found, '{} in:\n{}'.format(shape, output)
        output = output[found.end():]


@pytest.fixture(scope='module')
def output_of_a_demo(tmp_path_factory):
    """What a demo prints until it has driven forward and backward."""
    with Ros(tmp_path_factory.mktemp('demo')) as ros:
        demo = ros.start(os.path.join(ROOT, 'run'), 'demo', 'camera:=synthetic', 'web:=false',
                         start_new_session=True)
        demo.wait_output('(?s)drives forward.* blue=0, red=0.*stands.* red=33800.*drives backward')
        demo.interrupt()
        return demo.output
