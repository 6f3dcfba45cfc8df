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
def closed(monkeypatch):
    """The topics that were closed; /bad cannot be subscribed."""
    found = []

    def make(name):
        if name == '/bad':
            raise RuntimeError('no such topic')
        return SimpleNamespace(picture=name + ' as JPEG', encode=lambda: None,
                               close=lambda: found.append(name))
    monkeypatch.setattr(pictures, '_Topic', make)
    monkeypatch.setattr(pictures, 'RETRY_PERIOD_S', 0.01)
    return found


def test_a_topic_that_fails_does_not_end_the_others(closed, wait_for_threads):
    topics = PictureTopics()
    topics.allow(['/bad', '/good'])
    for names in ({'/bad'}, {'/bad', '/good'}, {'/good'}):
        topics.watch(names)
    wait_for(lambda: topics.latest('/good') == '/good as JPEG', 'the picture')
    topics.watch(set())
    wait_for_threads()
    assert closed == ['/good'] and topics.latest('/good') is None


def test_only_topics_that_are_allowed_are_subscribed(closed, wait_for_threads):
    topics = PictureTopics()
    topics.allow(iter(['/camera']))
    topics.watch({'/odom', '/camera'})
    wait_for(lambda: topics.latest('/camera') == '/camera as JPEG', 'the picture')
    assert topics.latest('/odom') is None
    topics.watch({'/odom'})
    wait_for_threads()
    assert closed == ['/camera']


def test_the_newest_image_in_its_own_size_and_colors(monkeypatch):
    monkeypatch.setattr(pictures, 'ImageSubscriber',
                        lambda name, callback: SimpleNamespace(callback=callback))
    topics = PictureTopics()
    topic = topics._topics['/camera'] = pictures._Topic('/camera')
    assert topics.image('/camera') is None and topics.image('/other') is None
    images = [np.full((50, 1000, 3), value, np.uint8) for value in (10, 20)]
    messages = [image_msgs.to_msg(image, 'rgb8', Header()) for image in images]
    for image, msg in zip(images, messages):
        image[..., 0] += 5
        msg.data = image.tobytes()
        topic._subscriber.callback(msg)
        topic.encode()
        found = topics.image('/camera')
        assert found.shape == (50, 1000, 3) and (found[..., ::-1] == image).all()
        shown = cv2.imdecode(np.frombuffer(topics.latest('/camera').jpeg, np.uint8), 1)
        assert shown.shape == (32, 640, 3)
    messages[1].data = b''
    assert topics.image('/camera') is None
