"""Which topics give pictures, with stand-ins for the subscribers."""
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from std_msgs.msg import Header

from img_recog.conversions import image_msgs
from img_recog.nodes.web import pictures
from img_recog.nodes.web.pictures import PictureTopics
from img_recog_helpers.waiting import wait_for


@pytest.fixture
def topics(monkeypatch):
    """A PictureTopics; `callbacks` of it are those of subscribers by topic, `closed` the topics
    that were closed. /bad cannot be subscribed.
    """
    made = PictureTopics()
    made.callbacks, made.closed = {}, []

    def subscribe(name, callback):
        if name == '/bad':
            raise RuntimeError('no such topic')
        made.callbacks[name] = callback
        return SimpleNamespace(close=lambda: made.closed.append(name))
    monkeypatch.setattr(pictures, 'ImageSubscriber', subscribe)
    monkeypatch.setattr(pictures, 'RETRY_PERIOD_S', 0.01)
    yield made
    made.watch(set())


def send(topics, name, image):
    """Let an image come on a topic once it is subscribed; return the picture of it."""
    before = topics.latest(name)
    callback = wait_for(lambda: topics.callbacks.get(name), 'the subscriber')
    callback(image_msgs.to_msg(image, 'rgb8', Header()))
    return wait_for(lambda: topics.latest(name) != before and topics.latest(name), 'the picture')


def test_only_topics_that_are_allowed_are_subscribed_and_one_that_fails_ends_no_other(
        topics, wait_for_threads):
    topics.allow(iter(['/bad', '/camera']))
    for names in ({'/bad'}, {'/bad', '/odom', '/camera'}, {'/odom', '/camera'}):
        topics.watch(names)
    assert topics.image('/camera') is None
    send(topics, '/camera', np.zeros((4, 6, 3), np.uint8))
    assert topics.latest('/odom') is None
    topics.watch({'/odom'})
    wait_for_threads()
    assert topics.closed == ['/camera'] == list(topics.callbacks)
    assert topics.latest('/camera') is None


def test_the_newest_image_in_its_own_size_and_colors(topics, wait_for_threads):
    topics.allow(['/camera'])
    topics.watch({'/camera'})
    assert topics.image('/other') is None
    for value in (10, 20):
        image = np.full((50, 1000, 3), value, np.uint8)
        image[..., 0] += 5
        picture = send(topics, '/camera', image)
        found = topics.image('/camera')
        assert found.shape == (50, 1000, 3) and (found[..., ::-1] == image).all()
        shown = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), 1)
        assert shown.shape == (32, 640, 3) and shown[..., 2].mean() == pytest.approx(
            value + 5, abs=3)
    bad = image_msgs.to_msg(image, 'rgb8', Header())
    bad.data = b''
    topics.callbacks['/camera'](bad)
    wait_for(lambda: topics.image('/camera') is None, 'the image that cannot be used')
    assert topics.latest('/camera') == picture
