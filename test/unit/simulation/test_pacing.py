"""Pacing, the measured factor and its reports with a fake clock."""
import pytest

from img_recog.simulation import pacing
from img_recog.simulation.pacing import Pace

# a binary fraction, so that the expected times are exact
STEP_S = 0.0625


@pytest.fixture(autouse=True)
def wall_clock(clock, monkeypatch):
    monkeypatch.setattr(pacing.time, 'monotonic', clock)


def run(pace, clock, steps, work_s=0.0):
    """Simulate steps that take `work_s` each, wait after each one; return the wall time."""
    start = clock.now_s
    for _ in range(steps):
        clock.advance(work_s)
        clock.advance(pace.delay_s(STEP_S))
    return clock.now_s - start


def reports(pace, clock, *factors):
    """Measure a second at each factor; return the reports, one character for each."""
    found = ''
    for factor in factors:
        clock.advance(1.0)
        pace.measure(factor)
        found += {True: 'S', False: 'k', None: '.'}[pace.take_report()]
    return found


@pytest.mark.parametrize('factor, work_s, wall_s', [
    (1.0, 0.0, 10.0), (2.0, 0.0, 5.0), (0.5, 0.0, 20.0), (0.0, 0.0, 0.0), (1.0, 0.03125, 10.0)])
def test_simulated_time_passes_at_the_factor(clock, factor, work_s, wall_s):
    pace = Pace(factor)
    assert run(pace, clock, 160, work_s) == wall_s


def test_delay_is_what_is_left_of_the_step(clock):
    pace = Pace(2.0)
    clock.advance(0.0078125)
    assert pace.delay_s(STEP_S) == STEP_S / 2 - 0.0078125


def test_a_short_delay_is_made_up_for(clock):
    pace, start = Pace(1.0), clock.now_s
    clock.advance(0.5)
    assert [pace.delay_s(STEP_S) for _ in range(8)] == [0.0] * 8
    assert pace.delay_s(STEP_S) == STEP_S
    assert clock.now_s - start == 0.5


@pytest.mark.parametrize('behind_s, late', [(0.5, False), (0.50390625, True), (60.0, True)])
def test_a_long_delay_is_not_made_up_for(clock, behind_s, late):
    pace = Pace(1.0)
    clock.advance(STEP_S + behind_s)
    assert pace.delay_s(STEP_S) == 0.0
    assert pace.delay_s(STEP_S) == (STEP_S if late else 0.0)


def test_a_pause_and_another_factor_are_not_made_up_for(clock):
    pace = Pace(1.0)
    clock.advance(300.0)
    pace.restart()
    assert pace.delay_s(STEP_S) == STEP_S
    clock.advance(300.0)
    pace.delay_s(STEP_S)
    pace.set_wanted(2.0)
    assert pace.wanted == 2.0 and pace.delay_s(STEP_S) == STEP_S / 2


def test_factor_is_measured_per_second_and_the_last_one_is_kept(clock):
    pace, seen = Pace(1.0), []
    for wall_s, simulated_s in ((0.5, 3.0), (0.5, 0.5), (0.5, 0.5), (0.5, 0.0), (0.5, 0.0),
                                (0.4375, 0.0), (4.0625, 1.25), (1.0, 0.0)):
        clock.advance(wall_s)
        seen.append((pace.measure(simulated_s), pace.measured))
    assert seen == [(None, 0.0), (3.5, 3.5), (None, 3.5), (0.5, 0.5), (None, 0.5), (None, 0.5),
                    (0.25, 0.25), (0.0, 0.0)]


def test_a_slow_start_is_not_a_slow_machine(clock):
    pace = Pace(1.0)
    assert pace.take_report() is None       # nothing is measured yet
    assert reports(pace, clock, 0.19, *[0.99] * 10) == '.' * 11
    assert reports(pace, clock, 0.3, *[0.99] * 10) == '.' * 11       # nor is another program


def test_a_slow_machine_is_reported_by_its_factor_until_it_keeps_up(clock):
    pace = Pace(1.0)
    # worse by half, or 30 s later
    assert reports(pace, clock, 0.0, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2) == '..S..S.'
    assert reports(pace, clock, *[0.2] * 40).count('S') == 1
    # a few good seconds are not the end
    assert reports(pace, clock, *[0.95] * 4, 0.2, *[0.95] * 6) == '.' * 9 + 'k.'
    # then it is as at first
    assert reports(pace, clock, 0.8, 0.8, 0.8) == '.S.'
    assert pace.measured == 0.8


def test_nothing_is_reported_while_robots_are_added_or_time_is_paused(clock):
    pace = Pace(1.0)
    for disturb in (pace.disturb, pace.restart, lambda: pace.set_wanted(1.0)):
        for _ in range(30):
            disturb()
            assert reports(pace, clock, 0.0) == '.'
    assert reports(pace, clock, 0.2, 0.2) == '.S'        # the true factor afterwards
    assert pace.measured == 0.2


def test_as_fast_as_possible_is_never_too_slow(clock):
    assert reports(Pace(0.0), clock, *[0.01] * 40) == '.' * 40
