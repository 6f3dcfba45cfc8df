"""Stops of real recognitions whose images have just stopped."""
import random
import signal
import tempfile
import time

from img_recog_testing.processes import Ros
from img_recog_testing.waiting import wait_for

_MAX_DELAY_S = 0.2      # twice the time for which the node waits for an image
_AT_ONCE = 8


def stop_many(count, seed, deadline_s):
    """Stop at least `count` recognitions, some at a time; return the longest time, in s."""
    with tempfile.TemporaryDirectory(prefix='img_recog_stops_') as folder:
        with Ros(folder) as ros:
            ros.start_master()
            return max(stop_after_the_images(ros, _AT_ONCE, seed + first, deadline_s)
                       for first in range(0, count, _AT_ONCE))


def stop_after_the_images(ros, count, seed, deadline_s):
    """Start `count` recognitions; stop the camera, then each of them at a random moment.

    ros: a Ros with a running master; its other nodes may go on.
    Returns the seconds from the end of the camera to the end of the last recognition. Raises
    AssertionError when one does not end within `deadline_s`, or not with code 0.
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
    return time.monotonic() - begin_s
