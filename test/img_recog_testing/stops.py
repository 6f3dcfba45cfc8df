"""Stops of real recognitions whose images have just stopped."""
import random
import signal
import time

from img_recog_testing.waiting import wait_for

_MAX_DELAY_S = 0.2      # twice the time for which the node waits for an image


def stop_after_the_images(ros, count, seed, deadline_s):
    """Start `count` recognitions; stop the camera, then each of them at a random moment.

    ros: a Ros with a running master; its other nodes may go on.
    Raises AssertionError when one does not end within `deadline_s`, or not with code 0.
    """
    moments = random.Random(seed)
    camera = ros.start('rosrun', 'img_recog', 'usb_cam_node.py', '_video_device:=synthetic')
    nodes = [ros.start('rosrun', 'img_recog', 'color_img_recog.py',
                       '__name:=color_extract_{}'.format(number)) for number in range(count)]
    for node in nodes:
        node.wait_output('blue=')
    assert camera.interrupt() == 0, camera.output
    begin_s = time.monotonic()
    for delay_s, node in sorted(((moments.uniform(0, _MAX_DELAY_S), node) for node in nodes),
                                key=lambda pair: pair[0]):
        time.sleep(max(0.0, begin_s + delay_s - time.monotonic()))
        node.send_signal(signal.SIGINT)
    for node in nodes:
        wait_for(lambda: not node.is_running(), lambda: 'the end of a recognition, seed {}:\n{}'
                 .format(seed, node.output), deadline_s)
        assert node.wait() == 0, node.output
