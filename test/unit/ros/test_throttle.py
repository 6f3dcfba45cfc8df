"""Actions and warnings at most once per period of wall time."""
import pytest

from img_recog.ros.throttle import ChangeThrottle, Throttle, ThrottledWarning


def test_ready_once_in_a_period(clock):
    throttle = Throttle(5.0, clock)
    assert throttle.ready()
    assert not throttle.ready()
    clock.advance(4.9)
    assert not throttle.ready()
    clock.advance(0.2)
    assert throttle.ready() and not throttle.ready()


def test_ready_once_in_a_period_of_another_time(clock):
    throttle = Throttle(5.0, clock)
    assert [throttle.ready(time_s) for time_s in (10.0, 14.9, 15.0, 19.9, 0.0, 4.9)] == [
        True, False, True, False, True, False]      # time was reset to 0


@pytest.mark.parametrize('states, shown', [
    # one state per 0.1 s
    (['none'] * 50, [0]),
    (['none'] * 15 + ['blue'] * 20, [0, 15]),
    (['none'] * 5 + ['blue'] * 20, [0, 10]),
    (['none', 'blue'] * 25, [0, 11, 22, 33, 44]),
    (['none'] * 3 + ['blue'] * 3 + ['none'] * 20, [0])])
def test_a_line_is_shown_at_a_change_and_at_most_one_per_second(clock, states, shown):
    throttle, found = ChangeThrottle(1.0, clock), []
    for number, state in enumerate(states):
        if throttle.shows(state):
            found.append(number)
        clock.advance(0.1 + 1e-9)
    assert found == shown


def test_each_warning_once_in_five_seconds_and_three_different_ones(clock):
    lines = []
    warn = ThrottledWarning(clock, lambda text, line: lines.append(text % line))
    for number in (1, 1, 2, 1, 3, 4, 2):
        warn('frame skipped: %d %%', number)
    assert lines == ['frame skipped: 1 %', 'frame skipped: 2 %', 'frame skipped: 3 %']
    clock.advance(4.9)
    warn('frame skipped: %d %%', 1)
    assert len(lines) == 3
    clock.advance(0.2)
    warn('frame skipped: %d %%', 4)
    warn('frame skipped: %d %%', 1)
    assert lines[3:] == ['frame skipped: 4 %', 'frame skipped: 1 %']
