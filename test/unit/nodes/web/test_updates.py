"""Events and states since a cursor."""
from img_recog.nodes.web import updates as module
from img_recog.nodes.web.updates import Updates


def test_events_are_sent_once_and_states_when_they_change():
    updates = Updates()
    updates.add('asked', 1)
    updates.set('pose', [0, 0])
    updates.set('pose', [1, 0])
    cursor, first = updates.since(None)
    assert first == {'asked': [1], 'pose': [1, 0]}
    assert updates.since(cursor) == (cursor, {})
    updates.add('asked', 2)
    updates.add('asked', 3)
    updates.set('pose', [2, 0])
    second, found = updates.since(cursor)
    assert found == {'asked': [2, 3], 'pose': [2, 0]}
    assert updates.since(None)[1] == {'asked': [1, 2, 3], 'pose': [2, 0]}
    assert second > cursor


def test_old_events_and_too_many_states_are_dropped(monkeypatch):
    monkeypatch.setattr(module, '_MAX_EVENTS', 3)
    monkeypatch.setattr(module, 'MAX_STATES', 2)
    updates = Updates()
    assert [updates.set(name, 0) for name in 'abca'] == [True, True, False, True]
    assert updates.since(None)[1] == {'a': 0, 'b': 0}
    updates.clear()
    for number in range(5):
        updates.add('log', number)
    assert updates.since(None)[1] == {'log': [2, 3, 4]}


def test_the_path_has_positions_that_are_apart():
    updates = Updates()
    for x in (0.0, 0.01, 0.03, 0.04, 0.06):
        updates.extend_path(x, 1.0)
    updates.add('asked', 1)
    cursor, found = updates.since(None)
    assert found['path'] == [(0.0, 1.0), (0.03, 1.0), (0.06, 1.0)]
    updates.extend_path(0.07, 1.0)
    assert updates.since(cursor) == (cursor, {})
    for x in (0.4, 0.8):
        updates.extend_path(x, 1.0)
    assert updates.since(cursor)[1] == {'path': [(0.4, 1.0), (0.8, 1.0)]}
    assert updates.since(None)[1]['path'] == [*found['path'], (0.4, 1.0), (0.8, 1.0)]


def test_the_path_says_where_the_robot_was_moved():
    updates = Updates()
    for x in (0.0, 0.3, 0.31, 0.82, 0.2):
        updates.extend_path(x, 0.0)
    assert updates.since(None)[1]['path'] == [
        (0.0, 0.0), (0.3, 0.0), None, (0.82, 0.0), None, (0.2, 0.0)]
    updates.clear()
    updates.extend_path(5.0, 0.0)
    assert updates.since(None)[1]['path'] == [(5.0, 0.0)]


def test_nothing_remains_after_clear():
    updates = Updates()
    updates.add('asked', 1)
    updates.set('factor', 1.0)
    updates.extend_path(0.0, 0.0)
    cursor, _ = updates.since(None)
    updates.clear()
    assert updates.since(None) == (cursor, {})
    updates.add('asked', 2)
    assert updates.since(cursor)[1] == {'asked': [2]}
