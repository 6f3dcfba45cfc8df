"""A subscriber that comes later gets the last message when it is told to, and once."""
import numpy as np
import pytest
from std_msgs.msg import Header, String

from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.ros.transport.redelivery import Redelivery
from img_recog_helpers.wire import packet

pytestmark = pytest.mark.usefixtures('fast')


def test_messages(name, subscribe):
    redelivery = Redelivery()
    publisher = DirectPublisher(name, String, redelivery=redelivery)
    first = subscribe(name, String)
    publisher.publish(String('old'))
    publisher.publish(String('last'))
    assert not redelivery.is_needed()
    second = subscribe(name, String)
    assert second.is_idle() and redelivery.is_needed()
    for _ in range(2):
        redelivery.deliver()
        assert not redelivery.is_needed()
    assert [first.receive(), first.receive(), second.receive()] == [
        packet(String(text)) for text in ('old', 'last', 'last')]
    assert first.is_idle() and second.is_idle()
    redelivery.deliver(to_all=True)
    assert first.receive() == second.receive() == packet(String('last'))
    publisher.unregister()


def test_an_image_that_was_published_before_anybody_subscribed(name, subscribe):
    redelivery = Redelivery()
    publisher = ImagePublisher(name, redelivery)
    image = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for value in (image + 1, image):
        publisher.publish(value, 'rgb8', Header(frame_id='lens'))
    end = subscribe(name, String)
    assert end.is_idle()
    redelivery.deliver()
    assert end.receive()[-48:] == image.tobytes() and end.is_idle()
    publisher.unregister()


def test_what_was_sent_before_is_not_delivered(name, subscribe):
    redelivery = Redelivery()
    publisher = DirectPublisher(name, String, redelivery=redelivery)
    publisher.publish(String('old'))
    redelivery.clear()
    end = subscribe(name, String)
    assert not redelivery.is_needed()
    redelivery.deliver()
    assert end.is_idle()
    publisher.unregister()
