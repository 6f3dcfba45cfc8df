"""The pictures of topics go on when one of them fails."""
from types import SimpleNamespace

from img_recog.nodes.web import pictures
from img_recog.nodes.web.pictures import PictureTopics
from img_recog_testing.waiting import wait_for


def test_a_topic_that_fails_does_not_end_the_others(monkeypatch):
    closed = []

    def make(name, _max_bytes):
        if name == '/bad':
            raise RuntimeError('no such topic')
        return SimpleNamespace(picture=name + ' as JPEG', encode=lambda: None,
                               close=lambda: closed.append(name))
    monkeypatch.setattr(pictures, '_Topic', make)
    monkeypatch.setattr(pictures, '_RETRY_PERIOD_S', 0.01)
    topics = PictureTopics(100)
    topics.allow(['/bad', '/good'])
    topics.watch({'/bad'})
    topics.watch({'/bad', '/good'})
    topics.watch({'/good'})
    wait_for(lambda: topics.latest('/good') == '/good as JPEG', 'the picture')
    topics.watch(set())
    wait_for(lambda: closed == ['/good'] and topics._thread is None, 'the end')


def test_only_topics_that_are_allowed_are_subscribed(monkeypatch):
    made = []
    monkeypatch.setattr(pictures, '_Topic', lambda name, _: made.append(name) or SimpleNamespace(
        picture=name + ' as JPEG', encode=lambda: None, close=lambda: None))
    topics = PictureTopics(100)
    topics.allow(iter(['/camera']))
    topics.watch({'/odom'})
    assert topics._thread is None
    topics.watch({'/odom', '/camera'})
    wait_for(lambda: topics.latest('/camera') == '/camera as JPEG', 'the picture')
    assert made == ['/camera'] and topics.latest('/odom') is None
    topics.watch(set())
    wait_for(lambda: topics._thread is None, 'the end')
