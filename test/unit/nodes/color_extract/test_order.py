"""The order in which color_extract publishes what it makes of a frame."""
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.nodes.color_extract import color_extract_node
from img_recog.nodes.color_extract.color_extract_node import ColorExtract, RecognitionDiagnostics
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Commander
from img_recog.recognition.recognition_settings import with_colors

BLUE, RED = (255, 0, 0), (80, 0, 255)


@pytest.fixture
def published(monkeypatch):
    """What a node publishes, in this order, and a function that gives it a frame."""
    order, frames = [], []
    monkeypatch.setattr(color_extract_node.rospy, 'get_time', lambda: 2.0)
    settings = with_colors()()
    node = ColorExtract.__new__(ColorExtract)
    silent = SimpleNamespace(get_num_connections=lambda: 0)
    node.__dict__.update(
        _settings=settings, _extractor=ColorExtractor(settings),
        _commander=Commander(settings, 0.0), _counts=RecognitionDiagnostics('/image'),
        _input=SimpleNamespace(decode=lambda msg: (frames.pop(), 'bgr8')),
        _shown=SimpleNamespace(shows=lambda commands: True),
        _line=SimpleNamespace(take_time=lambda: order.append('time of the line'),
                              write=lambda text, on_terminal: order.append(text)),
        _velocity=SimpleNamespace(publish=lambda msg: order.append(msg.linear.x)),
        _yielding=SimpleNamespace(is_active=lambda: False), _detection=silent, _overlay=silent,
        _masked=[SimpleNamespace(publish_drawn=lambda *_, name=name: order.append(name))
                 for name in ('blue_image', 'red_image')])

    def give(*colors):
        image = np.zeros((40, 80, 3), np.uint8)
        for number, color in enumerate(colors):
            image[:, 40 * number:40 * number + 40] = color
        msg = Image(header=Header(stamp=rospy.Time(1)))
        frames.append(image)
        del order[:]
        node.handle(msg)
        return order
    return give


def test_line_has_its_time_before_the_commands_and_blue_comes_first(published):
    assert published(BLUE, RED) == [
        'time of the line', 10.0, -10.0, 'blue=1600, red=1600', 'blue_image', 'red_image']


def test_frame_without_color_has_a_line_and_no_command(published):
    assert published() == ['time of the line', 'blue=0, red=0', 'blue_image', 'red_image']
