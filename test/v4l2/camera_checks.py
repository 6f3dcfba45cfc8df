"""Checks of the node usb_cam on the virtual camera of the kernel's driver vivid; see run.

Prints one line for each check and a summary; the exit code is 0 when all are well. The names,
numbers and defaults of the driver are those of drivers/media/test-drivers/vivid.
"""
import contextlib
import fcntl
import glob
import os
import pathlib
import re
import statistics
import struct
import sys
import tempfile
import time

import cv2
import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from dynamic_reconfigure.client import Client
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_srvs.srv import Empty

from img_recog_testing.processes import Ros
from img_recog_testing.waiting import wait_for

ROOT = pathlib.Path(__file__).resolve().parents[2]

NODE = ROOT / 'build' / 'devel' / 'lib' / 'img_recog' / 'usb_cam_node.py'
DRIVER = '/sys/bus/platform/drivers/vivid/'

# linux/v4l2-controls.h, and vivid-ctrls.c for the last one
BRIGHTNESS, CONTRAST, SATURATION, HUE = 0x00980900, 0x00980901, 0x00980902, 0x00980903
AUTO_GAIN, GAIN, PERCENTAGE_DROPPED = 0x00980912, 0x00980913, 0x00f0f040
# linux/videodev2.h
VIDIOC_S_PARM, VIDIOC_G_CTRL, VIDIOC_S_CTRL = 0xc0cc5616, 0xc008561b, 0xc008561c
VIDEO_CAPTURE, TIME_PER_FRAME = 1, 0x1000

# The node promises 2 s; the rest is for a guest that is emulated in software.
NOTICED_S = ENDED_S = 2.0 + 1.5
ROUNDS = 20

# pixel_format, FOURCC asked for, whether vivid has it, size asked for, size and rate that vivid
# gives, encoding
FORMATS = (('yuyv', 'YUYV', True, (320, 180), (320, 180), 30, 'rgb8'),
           ('uyvy', 'UYVY', True, (640, 360), (640, 360), 30, 'rgb8'),
           ('grey', 'GREY', True, (640, 480), (640, 480), 25, 'mono8'),
           ('rgb24', 'RGB3', True, (320, 180), (320, 180), 30, 'rgb8'),
           ('mjpeg', 'MJPG', False, (320, 180), (320, 180), 30, 'rgb8'),
           ('yuvmono10', 'Y10', True, (320, 180), (320, 180), 30, 'mono8'),
           ('yuyv', 'YUYV', True, (333, 222), (320, 180), 30, 'rgb8'))


class Checks:
    """Counts checks and prints how each went."""

    def __init__(self):
        self.good = self.bad = 0
        self._begin = time.monotonic()

    @contextlib.contextmanager
    def check(self, name, *nodes):
        """Run the body as one check; append what was found to the list that it is given.

        nodes: processes whose log is shown when the check fails.
        """
        found = []
        try:
            yield found
        except Exception as error:      # the other checks are worth running all the same
            self.bad += 1
            self._say('FAILED', name, ['{}: {}'.format(type(error).__name__, error)])
            for node in nodes:
                print('    ' + node.output.strip().replace('\n', '\n    '), flush=True)
        else:
            self.good += 1
            self._say('ok', name, found)

    def _say(self, verdict, name, found):
        print('{:5.0f} s {:6} {}{}'.format(
            time.monotonic() - self._begin, verdict, name,
            ': ' + '; '.join(map(str, found)) if found else ''), flush=True)


class Topic:
    """The messages of a topic as they come; the last one is kept, and all stamps, in ns."""

    def __init__(self, name, kind):
        self.last, self.stamps = None, []
        self._subscriber = rospy.Subscriber(name, kind, self._take)

    def _take(self, msg):
        self.last = msg
        self.stamps.append(msg.header.stamp.to_nsec())

    def more(self, count=1):
        """Wait for some more messages; return the last."""
        before = len(self.stamps)
        wait_for(lambda: len(self.stamps) >= before + count,
                 '{} more messages of {}'.format(count, self._subscriber.name))
        return self.last

    def close(self):
        self._subscriber.unregister()


class Diagnostics:
    """The states of the node usb_cam's camera, as /diagnostics tells them."""

    def __init__(self):
        self.levels, self.message = [], ''
        rospy.Subscriber('/diagnostics', DiagnosticArray, self._take)

    def _take(self, array):
        for status in array.status:
            if status.name == 'usb_cam: camera':
                self.message = status.message
                self.levels.append(status.level)

    def wait(self, level, text, count=1):
        """Wait until the next messages, so many in a row, have this level, and the last the text.

        text: a regular expression. Returns the last message.
        """
        begin = len(self.levels)
        wait_for(lambda: len(self.levels) >= begin + count
                 and self.levels[-count:] == [level] * count and re.search(text, self.message),
                 lambda: 'level {} on /diagnostics, got {} {}'.format(
                     level, self.levels[begin:], self.message))
        return self.message


class Vivid:
    """The device itself, past the node."""

    def __init__(self):
        self.path = wait_for(self._find, 'a device of vivid')

    @staticmethod
    def _find():
        found = glob.glob('/sys/bus/platform/devices/vivid.0/video4linux/video*')
        paths = ['/dev/' + os.path.basename(path) for path in sorted(found)]
        return paths[0] if paths and os.path.exists(paths[0]) else None

    def _ioctl(self, request, argument):
        descriptor = os.open(self.path, os.O_RDWR | os.O_NONBLOCK)
        try:
            return fcntl.ioctl(descriptor, request, argument)
        finally:
            os.close(descriptor)

    def get(self, control):
        return struct.unpack('=Ii', self._ioctl(VIDIOC_G_CTRL, struct.pack('=Ii', control, 0)))[1]

    def set(self, control, value):
        self._ioctl(VIDIOC_S_CTRL, struct.pack('=Ii', control, value))

    def set_rate(self, hertz):
        """Change the rate at which it gives frames, also while another program takes them."""
        self._ioctl(VIDIOC_S_PARM, struct.pack(
            '=7I', VIDEO_CAPTURE, TIME_PER_FRAME, 0, 1, hertz, 0, 0).ljust(204, b'\0'))

    def unplug(self):
        pathlib.Path(DRIVER, 'unbind').write_text('vivid.0')

    def plug(self):
        pathlib.Path(DRIVER, 'bind').write_text('vivid.0')
        back = wait_for(self._find, 'the device after it was bound again')
        assert back == self.path, '{} came back as {}'.format(self.path, back)

    def streams(self):
        """Return whether this process gets a frame of it."""
        capture = cv2.VideoCapture(self.path, cv2.CAP_V4L2)
        try:
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*'YUYV'))
            return capture.isOpened() and capture.read()[0]
        finally:
            capture.release()

    def held_by(self, process):
        """Return how many descriptors of the device a process has."""
        return sum(link == self.path for link in descriptors(process))


def descriptors(process):
    links, folder = [], '/proc/{}/fd'.format(process.pid)
    for name in os.listdir(folder):
        with contextlib.suppress(FileNotFoundError):        # closed meanwhile
            links.append(os.readlink(os.path.join(folder, name)))
    return links


def call(service):
    rospy.wait_for_service(service, 60)
    rospy.ServiceProxy(service, Empty)()


def lines(node, pattern):
    """Return the lines of a node's log that a regular expression is found in."""
    return [line for line in node.output.splitlines() if re.search(pattern, line)]


def time_of(line):
    return float(re.search(r'\] \[(\d+\.\d+)', line).group(1))


def steps_of(stamps):
    """Return the seconds between stamps, which are in nanoseconds."""
    stamps = list(stamps)           # more may come meanwhile
    return [(b - a) / 1e9 for a, b in zip(stamps, stamps[1:])]


def span_of(steps):
    return 'steps of {:.1f} to {:.1f} ms'.format(1000 * min(steps), 1000 * max(steps))


def pixels_of(msg):
    """Return a message's image, after a look at its layout."""
    channels = {'rgb8': 3, 'mono8': 1}[msg.encoding]
    assert msg.step == msg.width * channels, 'step {}'.format(msg.step)
    assert len(msg.data) == msg.step * msg.height, '{} bytes'.format(len(msg.data))
    return np.frombuffer(msg.data, np.uint8).reshape(msg.height, msg.width, channels)


def look_at_bars(image):
    """Look at vivid's color bars: white, yellow, cyan, green, magenta, red, blue, black."""
    height, width, channels = image.shape
    bars = [image[height * 8 // 10, width * (2 * bar + 1) // 16].astype(int) for bar in range(8)]
    if channels == 1:
        grey = [int(bar[0]) for bar in bars]
        assert grey == sorted(grey, reverse=True) and grey[0] > grey[7] + 100, grey
    else:
        red, blue = bars[5], bars[6]
        assert red[0] > red[2] + 80 and blue[2] > blue[0] + 80, [list(bar) for bar in bars]


def check_formats(checks, ros, vivid):
    """Formats and sizes: all nodes start at once, suspended, and have the device in turn."""
    nodes = [ros.start(
        NODE, '__name:=camera_{}'.format(number), '_video_device:=' + vivid.path,
        '_pixel_format:=' + name, '_image_width:={}'.format(asked[0]),
        '_image_height:={}'.format(asked[1]), '_create_suspended:=true')
        for number, (name, _, _, asked, _, _, _) in enumerate(FORMATS)]
    for number, (name, fourcc, has, asked, size, hertz, encoding) in enumerate(FORMATS):
        node, topic = nodes[number], '/camera_{}'.format(number)
        with checks.check('pixel_format {}, {}x{}'.format(name, *asked), node) as found:
            node.wait_output('suspended until {}/start_capture'.format(topic))
            assert not vivid.held_by(node), 'suspended, and the device is open'
            images = Topic(topic + '/image_raw', Image)
            infos = Topic(topic + '/camera_info', CameraInfo)
            call(topic + '/start_capture')
            match = node.wait_output(
                r'\[(\w+)\] .*asked for {} {}x{} at 30 Hz, got (\S+) (\d+)x(\d+) at (\S+) Hz'
                .format(fourcc, *asked))
            level, got, width, height, rate = match.groups()
            found.append('got {} {}x{} at {} Hz'.format(got, width, height, rate))
            assert (got == fourcc) == has, found
            assert level == ('INFO' if has and size == asked else 'WARN'), level
            assert (int(width), int(height), float(rate)) == size + (hertz,), found
            msg = images.more(20)
            assert (msg.width, msg.height) == size, '{}x{}'.format(msg.width, msg.height)
            assert msg.encoding == encoding, msg.encoding
            assert msg.header.frame_id == 'head_camera', msg.header.frame_id
            look_at_bars(pixels_of(msg))
            infos.more()
            assert (infos.last.width, infos.last.height) == size
            assert set(infos.stamps) & set(images.stamps), 'camera_info has other stamps'
            steps = steps_of(images.stamps)
            measured = 1 / statistics.median(steps)
            found.append('stamps at {:.1f} Hz, {}'.format(measured, span_of(steps)))
            assert abs(measured - hertz) < 0.15 * hertz, found
            assert min(steps) > 0, found
            images.close()
            infos.close()
        node.close()


def check_controls(checks, vivid, node):
    """What the parameters set at start, and what dynamic_reconfigure changes."""
    with checks.check('controls at start', node) as found:
        wanted = {'brightness': (BRIGHTNESS, 99), 'contrast': (CONTRAST, 120),
                  'saturation': (SATURATION, 110), 'gain': (GAIN, 42), 'hue': (HUE, 5)}
        values = {name: vivid.get(number) for name, (number, _) in wanted.items()}
        found.append(values)
        assert values == {name: value for name, (_, value) in wanted.items()}, values
    with checks.check('controls that the camera lacks: one warning each', node):
        for name in ('sharpness', 'nonsense'):
            told = lines(node, r'\[WARN\].*the camera has no control {}; '.format(name))
            assert len(told) == 1, told
    with checks.check('controls while it runs, by dynamic_reconfigure', node) as found:
        client = Client('/usb_cam', timeout=60)
        config = client.update_configuration({'brightness': 77})
        found.append('brightness {} of {}'.format(vivid.get(BRIGHTNESS), config['brightness']))
        assert vivid.get(BRIGHTNESS) == config['brightness'] == 77, found
        client.update_configuration({'contrast': 999})
        node.wait_output(r'\[WARN\].*control contrast: got 999, allowed is 0 to 255')
        client.update_configuration({'contrast': 121, 'brightness': 99})
        assert (vivid.get(CONTRAST), vivid.get(BRIGHTNESS)) == (121, 99)
        told = lines(node, 'no control sharpness')
        found.append('told {} times of the missing control'.format(len(told)))
        client.close()


def check_rate(checks, vivid, node, images):
    with checks.check('framerate 20 of a camera that gives 60', node) as found:
        vivid.set_rate(60)
        images.more(10)         # until the throttle knows its camera
        first = len(images.stamps)
        images.more(80)
        steps = steps_of(images.stamps[first:])
        rate = len(steps) / sum(steps)
        even = sum(abs(step - 0.05) < 0.012 for step in steps) / len(steps)
        found.append('{:.2f} Hz, {:.0%} of the steps 50 ms, {}'.format(
            rate, even, span_of(steps)))
        assert abs(rate - 20) < 1.5 and even > 0.5 and min(steps) > 0, found


def check_compressed(checks, node, images):
    with checks.check('image_raw/compressed', node) as found:
        topic = Topic('/usb_cam/image_raw/compressed', CompressedImage)
        msg = topic.more(3)
        found.append(msg.format)
        assert 'jpeg' in msg.format and msg.data[:2] == b'\xff\xd8', msg.data[:2]
        image = cv2.imdecode(np.frombuffer(msg.data, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape == (180, 320, 3), image.shape
        wait_for(lambda: set(topic.stamps) & set(images.stamps), 'the stamp of a raw image')
        topic.close()


def check_rounds(checks, vivid, node, images):
    with checks.check('{} rounds of stop_capture and start_capture'.format(ROUNDS), node) as found:
        counts = []
        for _ in range(ROUNDS):
            call('/usb_cam/stop_capture')
            assert not vivid.held_by(node), 'stopped, and the device is open'
            counts.append(len(descriptors(node)))
            call('/usb_cam/start_capture')
            images.more(2)
            assert vivid.held_by(node) == 1, descriptors(node)
        for service in ('start', 'stop', 'stop'):
            call('/usb_cam/{}_capture'.format(service))
        # a connection of the services' clients may take its time to close
        wait_for(lambda: len(descriptors(node)) <= counts[0],
                 lambda: 'descriptors: {} {}'.format(counts, descriptors(node)))
        found.append('descriptors {} to {}, then {}'.format(
            min(counts), max(counts), len(descriptors(node))))
    with checks.check('the device is free while stopped', node):
        before = len(images.stamps)
        assert vivid.streams(), 'no frame for another program'
        assert len(images.stamps) == before, 'images though it is stopped'
        call('/usb_cam/start_capture')
        images.more(2)


def check_losses(checks, vivid, node, images, diagnostics):
    """Unplugged and silent, and back, by a symlink and without a restart."""
    ways = (('unplugged', vivid.unplug, vivid.plug),
            ('silent', lambda: vivid.set(PERCENTAGE_DROPPED, 100),
             lambda: vivid.set(PERCENTAGE_DROPPED, 0)))
    for number, (name, lose, find) in enumerate(ways, 1):
        with checks.check('{}: told once and in time'.format(name), node) as found:
            diagnostics.wait(DiagnosticStatus.OK, 'Hz')
            lose()
            told = wait_for(lambda: lines(node, r'\[ERROR\].*camera lost: ')[number - 1:],
                            lambda: 'the loss in ' + node.output)
            late_s = time_of(told[0]) - images.stamps[-1] / 1e9
            found.append('{:.2f} s after the last image'.format(late_s))
            assert late_s < NOTICED_S, found
            found.append('diagnostics: ' + diagnostics.wait(DiagnosticStatus.ERROR, 'no frame', 4))
            told = lines(node, 'camera lost: ')
            assert len(told) == number, told
        with checks.check('{}: back without a restart'.format(name), node) as found:
            begin = time.monotonic()
            find()
            images.more(5)
            found.append('images {:.1f} s after it was'.format(time.monotonic() - begin))
            wait_for(lambda: len(lines(node, 'camera is back')) == number, 'being told so')
            found.append('diagnostics: ' + diagnostics.wait(DiagnosticStatus.OK, 'Hz'))
            assert vivid.get(BRIGHTNESS) == 99, 'brightness is {}'.format(vivid.get(BRIGHTNESS))
    with checks.check('SIGINT while the device is silent', node) as found:
        vivid.set(PERCENTAGE_DROPPED, 100)
        wait_for(lambda: time.time() - images.stamps[-1] / 1e9 > 0.5, 'the device to fall silent')
        begin = time.monotonic()
        code = node.interrupt()
        taken_s = time.monotonic() - begin
        found.append('exit code {} after {:.2f} s'.format(code, taken_s))
        assert code == 0 and taken_s < ENDED_S, found
        bad = lines(node, 'Traceback|terminate called|FATAL')
        assert not bad, bad
    vivid.set(PERCENTAGE_DROPPED, 0)


def check_missing(checks, ros, vivid):
    missing = next(path for path in map('/dev/video{}'.format, range(7, 100))
                   if not os.path.exists(path))
    node = ros.start(NODE, '__name:=missing', '_video_device:=' + missing)
    with checks.check('a device that is missing', node) as found:
        code = node.wait()
        told = lines(node, r'\[FATAL\]')
        found.extend(told)
        assert code == 1 and len(told) == 1, (code, told)
        assert missing + ':' in told[0] and vivid.path in told[0].partition('(have ')[2], told


def run(checks, ros, folder):
    core = ros.start('roscore', '-p', ros.port)
    core.wait_output('started core service')
    os.environ.update(ros.env)
    rospy.init_node('v4l2_checks', disable_signals=True)
    vivid = Vivid()
    print('kernel {}, {}, OpenCV {}'.format(os.uname().release, vivid.path, cv2.__version__),
          flush=True)
    check_formats(checks, ros, vivid)
    check_missing(checks, ros, vivid)

    link = folder / 'a camera by id'
    link.symlink_to(vivid.path)
    vivid.set(AUTO_GAIN, 0)         # else gain is what the driver likes
    rospy.set_param('/usb_cam', {
        'video_device': str(link), 'pixel_format': 'yuyv', 'image_width': 320,
        'image_height': 180, 'framerate': 20, 'brightness': 99, 'contrast': 120,
        'saturation': 110, 'gain': 42, 'sharpness': 4,
        'intrinsic_controls': {'hue': 5, 'nonsense': 3}})
    node = ros.start(NODE, '__name:=usb_cam')
    images, diagnostics = Topic('/usb_cam/image_raw', Image), Diagnostics()
    with checks.check('images by a symlink', node):
        images.more(2)
    check_controls(checks, vivid, node)
    check_rate(checks, vivid, node, images)
    check_compressed(checks, node, images)
    check_rounds(checks, vivid, node, images)
    check_losses(checks, vivid, node, images, diagnostics)


def main():
    if not os.path.isdir(DRIVER):
        sys.exit('the driver vivid is not loaded; use the script run beside this one')
    checks = Checks()
    with tempfile.TemporaryDirectory() as name:
        ros = Ros(pathlib.Path(name))
        try:
            with checks.check('all of it was run'):
                run(checks, ros, pathlib.Path(name))
        finally:
            rospy.signal_shutdown('done')
            ros.close()
    print('v4l2 checks: {} ok, {} failed'.format(checks.good, checks.bad), flush=True)
    return 1 if checks.bad else 0


if __name__ == '__main__':
    sys.exit(main())
