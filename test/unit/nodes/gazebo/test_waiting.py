"""When commands are due in lockstep."""
from types import SimpleNamespace

import pytest

from img_recog.nodes.gazebo.waiting import Waiting
from img_recog.simulation.simulated_model import Reading


@pytest.mark.parametrize('is_awaited', [True, False])
def test_a_reset_drops_the_answer_to_what_came_before_it_and_no_other(is_awaited):
    calls = []
    topics = SimpleNamespace(
        namespaces=lambda *_: [''], discard_commands=lambda: calls.append('discard'))
    lockstep = SimpleNamespace(kinds=['scan'], expect=lambda *_: None, notify_sent=lambda: None)
    waiting = Waiting(SimpleNamespace(), SimpleNamespace(), topics, lockstep)
    scan = [Reading('robot', 'scan', 'scan', 0.2, None)]
    waiting.expect(scan)
    if not is_awaited:
        waiting.take_commands()
    waiting.discard_commands()
    calls.clear()
    if is_awaited:
        assert waiting.take_commands() and calls == ['discard']
        calls.clear()
    waiting.expect(scan)
    assert waiting.take_commands() and not waiting.take_commands() and calls == []
