"""Events and states since a cursor."""
from img_recog.nodes.web import news as news_module
from img_recog.nodes.web.news import News


def test_events_are_sent_once_and_states_when_they_change():
    news = News()
    news.add('asked', 1)
    news.set('pose', [0, 0])
    news.set('pose', [1, 0])
    cursor, first = news.since(None)
    assert first == {'asked': [1], 'pose': [1, 0]}
    assert news.since(cursor) == (cursor, {})
    news.add('asked', 2)
    news.add('asked', 3)
    news.set('pose', [2, 0])
    second, found = news.since(cursor)
    assert found == {'asked': [2, 3], 'pose': [2, 0]}
    assert news.since(None)[1] == {'asked': [1, 2, 3], 'pose': [2, 0]}
    assert second > cursor


def test_old_events_are_dropped(monkeypatch):
    monkeypatch.setattr(news_module, '_MAX_EVENTS', 3)
    news = News()
    for number in range(5):
        news.add('log', number)
    assert news.since(None)[1] == {'log': [2, 3, 4]}


def test_the_path_has_positions_that_are_apart():
    news = News()
    for x in (0.0, 0.01, 0.03, 0.04, 0.06):
        news.extend_path(x, 1.0)
    news.add('asked', 1)
    cursor, found = news.since(None)
    assert found['path'] == [(0.0, 1.0), (0.03, 1.0), (0.06, 1.0)]
    news.extend_path(0.07, 1.0)
    assert news.since(cursor) == (cursor, {})
    for x in (0.4, 0.8):
        news.extend_path(x, 1.0)
    assert news.since(cursor)[1] == {'path': [(0.4, 1.0), (0.8, 1.0)]}
    assert news.since(None)[1]['path'] == [*found['path'], (0.4, 1.0), (0.8, 1.0)]


def test_the_path_says_where_the_robot_was_moved():
    news = News()
    for x in (0.0, 0.3, 0.31, 0.82, 0.2):
        news.extend_path(x, 0.0)
    assert news.since(None)[1]['path'] == [
        (0.0, 0.0), (0.3, 0.0), None, (0.82, 0.0), None, (0.2, 0.0)]
    news.clear()
    news.extend_path(5.0, 0.0)
    assert news.since(None)[1]['path'] == [(5.0, 0.0)]


def test_nothing_remains_after_clear():
    news = News()
    news.add('asked', 1)
    news.set('factor', 1.0)
    news.extend_path(0.0, 0.0)
    cursor, _ = news.since(None)
    news.clear()
    assert news.since(None) == (cursor, {})
    news.add('asked', 2)
    assert news.since(cursor)[1] == {'asked': [2]}
