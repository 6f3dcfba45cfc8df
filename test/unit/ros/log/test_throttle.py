"""Actions and warnings at most once per period of wall time."""
from img_recog.ros.log.throttle import Throttle, ThrottledWarning


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
