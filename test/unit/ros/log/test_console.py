"""The terminal shows only lines about changes; other handlers get all lines."""
import logging

import pytest
from rosgraph.roslogging import RosStreamHandler

from img_recog.ros.log import console
from img_recog.ros.log.console import ConsoleThrottle


@pytest.mark.parametrize('states, shown', [
    # one state per 0.1 s
    (['none'] * 50, [0]),
    (['none'] * 15 + ['blue'] * 20, [0, 15]),
    (['none'] * 5 + ['blue'] * 20, [0, 10]),
    (['none', 'blue'] * 25, [0, 11, 22, 33, 44]),
    (['none'] * 3 + ['blue'] * 3 + ['none'] * 20, [0])])
def test_a_line_is_shown_at_a_change_and_at_most_one_per_second(clock, states, shown):
    throttle, found = ConsoleThrottle(1.0, clock), []
    for number, state in enumerate(states):
        if throttle.shows(state):
            found.append(number)
        clock.advance(0.1 + 1e-9)
    assert found == shown


def test_lines_are_hidden_only_in_the_terminal(monkeypatch, capsys):
    class Kept(logging.Handler):
        lines = []

        def emit(self, record):
            self.lines.append(record.getMessage())

    logger = logging.getLogger('rosout')
    monkeypatch.setattr(logger, 'handlers', [RosStreamHandler(colorize=False), Kept()])
    monkeypatch.setattr(logger, 'level', logging.INFO)
    monkeypatch.setattr(logger, 'propagate', False)
    console.install_filter()
    logger.info('hidden', extra=console.mark(False))
    logger.info('shown', extra=console.mark(True))
    logger.info('ordinary')
    assert Kept.lines == ['hidden', 'shown', 'ordinary']
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[-1] for line in lines] == ['shown', 'ordinary']
