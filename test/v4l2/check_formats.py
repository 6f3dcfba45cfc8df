"""Pixel formats and sizes: what is negotiated, and the images that are published."""
import statistics

import numpy as np
from sensor_msgs.msg import CameraInfo, Image

from camera_node import PROGRAM, Topic, call, intervals, range_text

# pixel_format, requested FOURCC, whether vivid has it, requested size, size and rate that vivid
# gives, encoding
FORMATS = (('yuyv', 'YUYV', True, (320, 180), (320, 180), 30, 'rgb8'),
           ('uyvy', 'UYVY', True, (640, 360), (640, 360), 30, 'rgb8'),
           ('grey', 'GREY', True, (640, 480), (640, 480), 25, 'mono8'),
           ('rgb24', 'RGB3', True, (320, 180), (320, 180), 30, 'rgb8'),
           ('mjpeg', 'MJPG', False, (320, 180), (320, 180), 30, 'rgb8'),
           ('yuvmono10', 'Y10', True, (320, 180), (320, 180), 30, 'mono8'),
           ('yuyv', 'YUYV', True, (333, 222), (320, 180), 30, 'rgb8'))


def check_formats(report, ros, vivid):
    """Start all nodes at once, suspended; each opens the device in turn."""
    nodes = [ros.start(
        PROGRAM, '__name:=camera_{}'.format(number), '_video_device:=' + vivid.path,
        '_pixel_format:=' + name, '_image_width:={}'.format(requested[0]),
        '_image_height:={}'.format(requested[1]), '_create_suspended:=true')
        for number, (name, _, _, requested, _, _, _) in enumerate(FORMATS)]
    for number, case in enumerate(FORMATS):
        node, namespace = nodes[number], '/camera_{}'.format(number)
        with report.check('pixel_format {}, {}x{}'.format(case[0], *case[3]), node) as measured:
            node.wait_output('suspended until {}/start_capture'.format(namespace))
            assert not vivid.held_by(node), 'suspended, and the device is open'
            _check_format(node, namespace, case, measured)
        node.close()


def _check_format(node, namespace, case, measured):
    _, fourcc, has_format, requested, size, hertz, encoding = case
    images = Topic(namespace + '/image_raw', Image)
    infos = Topic(namespace + '/camera_info', CameraInfo)
    call(namespace + '/start_capture')
    match = node.wait_output(
        r'\[(\w+)\] .*asked for {} {}x{} at 30 Hz, got (\S+) (\d+)x(\d+) at (\S+) Hz'.format(
            fourcc, *requested))
    level, got, width, height, rate = match.groups()
    measured.append('got {} {}x{} at {} Hz'.format(got, width, height, rate))
    assert (got == fourcc) == has_format, measured
    assert level == ('INFO' if has_format and size == requested else 'WARN'), level
    assert (int(width), int(height), float(rate)) == size + (hertz,), measured
    msg = images.wait_more(20)
    assert (msg.width, msg.height) == size, '{}x{}'.format(msg.width, msg.height)
    assert msg.encoding == encoding, msg.encoding
    assert msg.header.frame_id == 'head_camera', msg.header.frame_id
    _check_color_bars(_pixels(msg))
    infos.wait_more()
    assert (infos.last.width, infos.last.height) == size
    assert set(infos.stamps) & set(images.stamps), 'camera_info has other stamps'
    intervals_s = intervals(images.stamps)
    rate_hz = 1 / statistics.median(intervals_s)
    measured.append('stamps at {:.1f} Hz, {}'.format(rate_hz, range_text(intervals_s)))
    assert abs(rate_hz - hertz) < 0.15 * hertz, measured
    assert min(intervals_s) > 0, measured
    images.close()
    infos.close()


def _pixels(msg):
    """Return the image of a message after a check of its layout."""
    channels = {'rgb8': 3, 'mono8': 1}[msg.encoding]
    assert msg.step == msg.width * channels, 'step {}'.format(msg.step)
    assert len(msg.data) == msg.step * msg.height, '{} bytes'.format(len(msg.data))
    return np.frombuffer(msg.data, np.uint8).reshape(msg.height, msg.width, channels)


def _check_color_bars(image):
    """Check the color bars of vivid: white, yellow, cyan, green, magenta, red, blue, black."""
    height, width, channels = image.shape
    bars = [image[height * 8 // 10, width * (2 * bar + 1) // 16].astype(int) for bar in range(8)]
    if channels == 1:
        grey = [int(bar[0]) for bar in bars]
        assert grey == sorted(grey, reverse=True) and grey[0] > grey[7] + 100, grey
    else:
        red, blue = bars[5], bars[6]
        assert red[0] > red[2] + 80 and blue[2] > blue[0] + 80, [list(bar) for bar in bars]
