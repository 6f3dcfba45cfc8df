"""Publishers that need no master."""
import numpy as np
import pytest

from img_recog.nodes.gazebo import camera_topics, images


class FakePublisher:
    """Takes what is published; `subscribers` is set by the test."""

    made = {}

    def __init__(self, topic, *_, **__):
        self.sent, self.subscribers, self.is_ended = [], 0, False
        self.made[topic] = self

    def get_num_connections(self):
        return self.subscribers

    def publish(self, *values):
        self.sent.append(values)

    def publish_data(self, draw, shape, msg):
        if self.subscribers:
            data = np.zeros(shape, np.uint8)
            draw(data)
            msg.data = data.tobytes()
            self.publish(msg)

    def unregister(self):
        self.is_ended = True


class FakeCompressed(FakePublisher):
    def __init__(self, topic, latch=False):
        super().__init__(topic + '/compressed')

    def is_wanted(self):
        return self.subscribers > 0

    def close(self):
        self.unregister()


@pytest.fixture
def publishers(monkeypatch):
    """The publishers of images that are made, by topic."""
    monkeypatch.setattr(FakePublisher, 'made', {})
    for module in (camera_topics, images):
        monkeypatch.setattr(module, 'ImagePublisher', FakePublisher)
    monkeypatch.setattr(camera_topics, 'CompressedImages', FakeCompressed)
    for name in ('publisher', 'LargePublisher'):
        monkeypatch.setattr(camera_topics, name, FakePublisher)
    return FakePublisher.made
