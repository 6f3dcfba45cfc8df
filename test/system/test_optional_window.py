"""Windows of other packages in the demo: started if they are there, else one line."""
import os
import select
import socket
import stat
import subprocess
import threading

import pytest

from img_recog_helpers.simulator_tools import drive
from img_recog_helpers.waiting import wait_for


@pytest.fixture
def with_package(tmp_path):
    """The environment with a package `shown` whose program writes its arguments to a file."""
    folder = tmp_path / 'packages' / 'shown'
    folder.mkdir(parents=True)
    (folder / 'package.xml').write_text(
        '<package><name>shown</name><version>1.0.0</version><description>d</description>'
        '<maintainer email="a@b.invalid">m</maintainer><license>BSD</license></package>')
    program = folder / 'program'
    program.write_text('#!/bin/sh\necho "$@" >{}/arguments\n'.format(tmp_path))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return {'ROS_PACKAGE_PATH': '{}:{}'.format(folder.parent, os.environ['ROS_PACKAGE_PATH'])}


def start(ros, *arguments, **env):
    return ros.start_node('optional_window.py', *arguments, env=dict(ros.env, **env))


@pytest.mark.display
def test_a_program_that_is_there_is_started_with_its_arguments(ros, display, tmp_path,
                                                               with_package):
    process = start(ros, 'shown', 'program', '-d', 'a file', '__name:=rviz', **with_package)
    assert process.wait() == 0, process.output
    assert (tmp_path / 'arguments').read_text() == '-d a file __name:=rviz\n'


@pytest.mark.display
def test_a_display_that_resets_itself_is_tried_again(ros, display, with_package):
    server = '/tmp/.X11-unix/X' + ros.env['DISPLAY'][1:]
    listener = socket.create_server(('127.0.0.1', 0))

    def serve():
        listener.accept()[0].close()
        with listener, listener.accept()[0] as client, socket.socket(socket.AF_UNIX) as xvfb:
            xvfb.connect(server)
            while True:
                for sender in select.select([client, xvfb], [], [])[0]:
                    data = sender.recv(1 << 16)
                    if not data:
                        return
                    (xvfb if sender is client else client).sendall(data)
    threading.Thread(target=serve, daemon=True).start()
    process = start(ros, 'shown', 'program', DISPLAY='127.0.0.1:{}'.format(
        listener.getsockname()[1] - 6000), **with_package)
    assert process.wait() == 0 and process.output == ''


def test_without_the_package_a_line_says_how_to_get_it(ros):
    process = start(ros, 'rqt_nowhere', 'rqt_nowhere', '__name:=rqt', DISPLAY=':0')
    assert process.wait() == 0
    assert process.output == (
        '[rqt] no window: rqt_nowhere is not installed: install the package rqt-nowhere (Debian, '
        'if it has it) or ros-noetic-rqt-nowhere\n')


@pytest.mark.parametrize('name, words', [
    ('', 'there is no display'), (':4711', 'no X server can be used at DISPLAY=:4711'),
    ('nonsense', 'no X server can be used at DISPLAY=nonsense'),
    ('localhost:99.0', 'no X server can be used at DISPLAY=localhost:99.0')])
def test_without_a_display_a_line_says_what_to_do(ros, with_package, name, words):
    process = start(ros, 'shown', 'program', DISPLAY=name, **with_package)
    assert process.wait() == 0
    assert process.output == ('[program] no window: {}: set DISPLAY, or look at the page '
                              '(web:=true)\n'.format(words))


def test_the_demo_goes_on_without_a_window(ros):
    demo = ros.demo('vision:=false', 'camera:=none', 'world:=empty', 'gui:=true',
                    'rqt_graph:=true', 'rviz:=true', 'rqt_reconfigure:=true')
    demo.wait_output('(?s)(no window: .*){4}')
    demo.wait_output('no window: .*the simulation goes on')
    drive(ros, 0.1)
    demo.wait_output('the robot drives forward')
    assert demo.interrupt() == 0
    assert demo.output.count('no window: ') == 4


@pytest.mark.display
def test_the_windows_of_the_demo_print_no_warnings_of_qt(ros, display):
    ros.env.pop('XDG_RUNTIME_DIR', None)
    demo = ros.demo('simulator:=false', 'camera:=synthetic', 'image_view:=true', 'teleop:=false',
                    'web:=false')
    demo.wait_output('camera: synthetic')
    wait_for(lambda: subprocess.run(['xwininfo', '-root', '-tree'], env=ros.env, check=False,
                                    stdout=subprocess.PIPE).stdout.count(b'_image"') >= 2,
             'the windows')
    assert demo.interrupt() == 0
    assert 'QStandardPaths' not in demo.output and 'Timers' not in demo.output, demo.output
