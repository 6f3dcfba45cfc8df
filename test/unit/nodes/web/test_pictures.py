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
    topics.watch({'/bad'})
    topics.watch({'/bad', '/good'})
    topics.watch({'/good'})
    wait_for(lambda: topics.latest('/good') == '/good as JPEG', 'the picture')
    topics.watch(set())
    wait_for(lambda: closed == ['/good'] and topics._thread is None, 'the end')
