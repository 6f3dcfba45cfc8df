"""Events and states since a cursor."""
from img_recog.nodes.web import updates as module
from img_recog.nodes.web.updates import Updates


def test_old_events_and_too_many_states_are_dropped(monkeypatch):
    monkeypatch.setattr(module, 'MAX_STATES', 2)
    updates = Updates()
    assert [updates.set(name, 0) for name in 'abca'] == [True, True, False, True]
    for number in range(500):
        updates.add('log', number, 3)
        updates.add('asked', number)
    assert updates.since(None)[1] == {
        'a': 0, 'b': 0, 'log': [497, 498, 499], 'asked': list(range(100, 500))}


def test_nothing_remains_after_clear():
    updates = Updates()
    updates.add('asked', 1)
    updates.set('factor', 1.0)
    cursor, _ = updates.since(None)
    updates.clear()
    assert updates.since(None) == (cursor, {})
    updates.add('asked', 2)
    assert updates.since(cursor)[1] == {'asked': [2]}
