"""The camera node as a process: how it starts and stops with all kinds of sources."""
import contextlib
import re
import signal
import socket
import subprocess

import cv2
import numpy as np
import pytest

from img_recog_helpers import wire
from img_recog_helpers.processes import Process
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for


def start(roscore, *parameters):
    roscore.set_parameters('/usb_cam')
    return roscore.start_node('usb_cam_node.py', *parameters)


@pytest.fixture(scope='module')
def services(roscore):
    calls = ServiceCalls(roscore)
    yield calls
    calls.close()


@pytest.mark.parametrize('interrupt', [Process.interrupt, Process.interrupt_thread])
def test_interrupt_ends_it_while_its_source_blocks(roscore, interrupt):
    with socket.socket() as server:         # accepts a connection and never answers
        server.bind(('127.0.0.1', 0))
        server.listen(1)
        server.settimeout(DEADLINE_S * stretch())
        for _ in range(10):
            camera = start(roscore, '_video_device:=http://me:secret@127.0.0.1:{}/live'.format(
                server.getsockname()[1]))
            call, _ = server.accept()       # now FFmpeg waits for an answer
            with contextlib.suppress(ValueError):       # it has ended, and has no thread
                interrupt(camera)
            code = camera.wait()
            call.close()
            if 'or not within' not in camera.output:
                break       # else the machine was so busy that FFmpeg has given up before
    assert code == 0, camera.output
    assert 'secret' not in camera.output and 'terminate' not in camera.output


def test_folder_without_loop_ends_with_one_line_and_exit_code_0(roscore, tmp_path):
    for number in range(3):
        assert cv2.imwrite(str(tmp_path / '{}.png'.format(number)), np.zeros((8, 8, 3), np.uint8))
    camera = start(roscore, '_video_device:={}'.format(tmp_path), '_loop:=false')
    assert camera.wait() == 0, camera.output
    assert len(re.findall(r'\[INFO\].*the folder .* has ended after 3 images', camera.output)) == 1
    assert not re.search(r'WARN|ERROR|FATAL', camera.output), camera.output


def test_suspended_camera_opens_its_source_on_start_capture(roscore, services, tmp_path):
    camera = start(roscore, '_video_device:={}/later'.format(tmp_path), '_create_suspended:=true')
    camera.wait_output('camera: suspended until /usb_cam/start_capture is called')
    services.call('/usb_cam/start_capture', {})
    camera.wait_output(r'\[ERROR\].*/later: no such file.*; still suspended')
    (tmp_path / 'later').mkdir()
    assert cv2.imwrite(str(tmp_path / 'later' / '0.png'), np.zeros((8, 8, 3), np.uint8))
    services.call('/usb_cam/start_capture', {})
    camera.wait_output(r'camera: folder .*/later of 1 image, 8x8')
    assert camera.interrupt() == 0


def test_start_of_a_source_that_is_gone_leaves_the_camera_stopped(roscore, services, tmp_path):
    path = tmp_path / 'still.png'
    assert cv2.imwrite(str(path), np.zeros((8, 8, 3), np.uint8))
    camera = start(roscore, '_video_device:={}'.format(path))
    services.call('/usb_cam/stop_capture', {})
    path.unlink()
    services.call('/usb_cam/start_capture', {})
    camera.wait_output(r'\[ERROR\].*/still.png: no such file.*; still stopped')
    assert cv2.imwrite(str(path), np.zeros((6, 6, 3), np.uint8))
    services.call('/usb_cam/start_capture', {})
    camera.wait_output(r'camera: image .*/still.png, 6x6')
    assert camera.interrupt() == 0


def test_a_video_whose_size_changes_is_one_line(roscore, tmp_path):
    with open(str(tmp_path / 'joined.ts'), 'wb') as joined:
        for size in ('96x64', '128x96'):
            subprocess.run(['ffmpeg', '-v', 'error', '-f', 'lavfi', '-i',
                            'testsrc2=size={}:rate=10:duration=1'.format(size), '-c:v', 'libx264',
                            '-pix_fmt', 'yuv420p', '-f', 'mpegts', '-'], check=True, stdout=joined)
    camera = start(roscore, '_video_device:={}'.format(joined.name), '_loop:=false')
    assert camera.wait() == 0, camera.output
    assert len(re.findall(r'\[WARN\].*joined.ts is 128x96: the images have this size',
                          camera.output)) == 1
    assert 'ERROR' not in camera.output, camera.output


def test_a_crash_has_a_line_that_names_the_source(roscore, tmp_path):
    path = str(tmp_path / 'film.png')
    assert cv2.imwrite(path, np.zeros((8, 8, 3), np.uint8))
    camera = start(roscore, '_video_device:=' + path)
    camera.wait_output('image .*film.png')
    camera.send_signal(signal.SIGSEGV)
    assert camera.wait() == -signal.SIGSEGV
    assert '<usb_cam reads {}>'.format(path) in camera.output


def subscribers(roscore):
    """Return the nodes that the master knows as subscribers of the images."""
    state = roscore.master().getSystemState('/test')[2]
    return dict(state[1]).get('/usb_cam/image_raw', [])


def connected(roscore):
    """Return the nodes to which the camera is connected to send images."""
    uri = wire.node_uri(roscore.master_uri, '/usb_cam')
    return {peer for _, peer, way, _, topic, *_ in wire.call(uri, 'getBusInfo')
            if way == 'o' and topic == '/usb_cam/image_raw'}


class Recognition:
    """color_extract with a log folder."""

    def __init__(self, roscore, folder):
        self._folder = folder
        self.process = roscore.start_node('color_img_recog.py',
                                          env=dict(roscore.env, ROS_LOG_DIR=str(folder)))
        wait_for(lambda: '/color_extract' in subscribers(roscore), lambda: self.process.output)

    def areas(self):
        """Return the area of blue in each frame, as logged."""
        text = ''.join(path.read_text() for path in self._folder.glob('color_extract*.log'))
        return [int(area) for area in re.findall(r'blue=(\d+), red=\d+\n', text)]


def test_a_recorded_bag_gives_the_same_areas_as_the_camera(roscore, services, tmp_path):
    bag = str(tmp_path / 'camera.bag')
    roscore.set_parameters('/usb_cam')
    live = Recognition(roscore, tmp_path / 'live')
    record = roscore.start('rosbag', 'record', '-O', bag, '/usb_cam/image_raw')
    # so slow that a busy machine drops no frame: those in which a card enters have other areas
    camera = start(roscore, '_video_device:=synthetic', '_image_width:=160', '_image_height:=120',
                   '_framerate:=8', '_create_suspended:=true')
    # the first frame is for both
    roscore.node_pid('/usb_cam')        # another one of this name was killed
    wait_for(lambda: len(connected(roscore)) == 2, lambda: connected(roscore))
    services.call('/usb_cam/start_capture', {})
    wait_for(lambda: len(set(live.areas())) > 3 and live.areas()[-1] == 0, live.areas)
    for process in (camera, record, live.process):
        assert process.interrupt() == 0, process.output
    replayed = Recognition(roscore, tmp_path / 'replayed')
    play = roscore.start('rosbag', 'play', '--wait-for-subscribers', '--rate', '1.5', bag)
    assert play.wait() == 0, play.output
    seen = live.areas()
    wait_for(lambda: 0 in replayed.areas()[-3:], replayed.areas)
    again = replayed.areas()
    # each may have missed a frame; the frames that both got give the same areas
    assert max(again) == max(seen) > 1000
    assert set(again) == set(seen)
    counts = [sum(map(bool, areas)) for areas in (again, seen)]
    assert max(counts) < 1.5 * min(counts), counts
