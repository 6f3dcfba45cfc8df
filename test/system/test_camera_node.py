"""The camera node as a process: how it ends, whatever its source does."""
import re
import socket
import time

import cv2
import numpy as np

CAMERA = ('rosrun', 'img_recog', 'usb_cam_node.py')


def start(roscore, *parameters):
    roscore.run('rosparam', 'delete', '/usb_cam')
    return roscore.start(*CAMERA, *parameters)


def test_interrupt_ends_it_within_two_seconds_while_its_source_blocks(roscore):
    with socket.socket() as server:         # takes the call and never says a word
        server.bind(('127.0.0.1', 0))
        server.listen(1)
        server.settimeout(60)
        camera = start(roscore, '_video_device:=http://me:secret@127.0.0.1:{}/live'.format(
            server.getsockname()[1]))
        call, _ = server.accept()           # and now OpenCV waits for an answer
        begin = time.monotonic()
        assert camera.interrupt() == 0, camera.output
        assert time.monotonic() - begin < 2.5
        call.close()
    assert 'secret' not in camera.output and 'terminate' not in camera.output


def test_folder_without_loop_ends_well_with_one_line(roscore, tmp_path):
    for number in range(3):
        assert cv2.imwrite(str(tmp_path / '{}.png'.format(number)), np.zeros((8, 8, 3), np.uint8))
    camera = start(roscore, '_video_device:={}'.format(tmp_path), '_loop:=false')
    assert camera.wait() == 0, camera.output
    assert len(re.findall(r'\[INFO\].*the folder .* is over after 3 images', camera.output)) == 1
    assert not re.search(r'WARN|ERROR|FATAL', camera.output), camera.output


def test_suspended_camera_opens_its_source_when_it_is_told_to(roscore, tmp_path):
    camera = start(roscore, '_video_device:={}/later'.format(tmp_path), '_create_suspended:=true')
    camera.wait_output('camera: suspended until /usb_cam/start_capture is called')
    roscore.wait_run('start_capture', 'rosservice', 'list')
    roscore.run('rosservice', 'call', '/usb_cam/start_capture')
    camera.wait_output(r'\[ERROR\].*/later: no such file or device.*; still suspended')
    (tmp_path / 'later').mkdir()
    assert cv2.imwrite(str(tmp_path / 'later' / '0.png'), np.zeros((8, 8, 3), np.uint8))
    roscore.run('rosservice', 'call', '/usb_cam/start_capture')
    camera.wait_output(r'camera: folder .*/later of 1 images, 8x8')
    assert camera.interrupt() == 0
