"""Which topics give pictures, with stand-ins for the subscribers."""
from types import SimpleNamespace

import pytest

from img_recog.nodes.web import pictures
from img_recog.nodes.web.pictures import PictureTopics
from img_recog_testing.waiting import wait_for


@pytest.fixture
def closed(monkeypatch):
    """The topics that were closed; /bad cannot be subscribed."""
    found = []

    def make(name, _max_bytes):
        if name == '/bad':
            raise RuntimeError('no such topic')
        return SimpleNamespace(picture=name + ' as JPEG', encode=lambda: None,
                               close=lambda: found.append(name))
    monkeypatch.setattr(pictures, '_Topic', make)
    monkeypatch.setattr(pictures, '_RETRY_PERIOD_S', 0.01)
    return found


def test_a_topic_that_fails_does_not_end_the_others(closed, wait_for_threads):
    topics = PictureTopics(100)
    topics.allow(['/bad', '/good'])
    for names in ({'/bad'}, {'/bad', '/good'}, {'/good'}):
        topics.watch(names)
    wait_for(lambda: topics.latest('/good') == '/good as JPEG', 'the picture')
    topics.watch(set())
    wait_for_threads()
    assert closed == ['/good'] and topics.latest('/good') is None


def test_only_topics_that_are_allowed_are_subscribed(closed, wait_for_threads):
    topics = PictureTopics(100)
    topics.allow(iter(['/camera']))
    topics.watch({'/odom', '/camera'})
    wait_for(lambda: topics.latest('/camera') == '/camera as JPEG', 'the picture')
    assert topics.latest('/odom') is None
    topics.watch({'/odom'})
    wait_for_threads()
    assert closed == ['/camera']
