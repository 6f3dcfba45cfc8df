"""Pacing, the measured factor and its reports with a fake clock."""
import pytest

from img_recog.simulation.pacing import Pace

# a binary fraction, so that the expected times are exact
STEP_S = 0.0625


def run(pace, clock, steps, work_s=0.0):
    """Simulate steps that take `work_s` each, wait after each one; return the wall time."""
    start = clock.now_s
    for _ in range(steps):
        clock.advance(work_s)
        clock.advance(pace.delay_s(STEP_S))
    return clock.now_s - start


def is_late(pace, clock):
    """Return whether simulated time has fallen behind, as a report says after a measurement."""
    clock.advance(1.0)
    pace.measure(1.0)
    return pace.is_to_report()


@pytest.mark.parametrize('factor, work_s, wall_s', [
    (1.0, 0.0, 10.0), (2.0, 0.0, 5.0), (0.5, 0.0, 20.0), (0.0, 0.0, 0.0), (1.0, 0.03125, 10.0)])
def test_simulated_time_passes_at_the_factor(clock, factor, work_s, wall_s):
    pace = Pace(factor, now=clock)
    assert run(pace, clock, 160, work_s) == wall_s
    assert not is_late(pace, clock)


def test_delay_is_what_is_left_of_the_step(clock):
    pace = Pace(2.0, now=clock)
    clock.advance(0.0078125)
    assert pace.delay_s(STEP_S) == STEP_S / 2 - 0.0078125


def test_a_short_delay_is_made_up_for(clock):
    pace, start = Pace(1.0, now=clock), clock.now_s
    clock.advance(0.5)
    assert [pace.delay_s(STEP_S) for _ in range(8)] == [0.0] * 8
    assert pace.delay_s(STEP_S) == STEP_S
    assert clock.now_s - start == 0.5
    assert not is_late(pace, clock)


@pytest.mark.parametrize('factor, behind_s, late', [
    (1.0, 0.5, False), (1.0, 0.50390625, True), (1.0, 60.0, True), (0.0, 3600.0, False)])
def test_it_is_late_after_more_than_half_a_second(clock, factor, behind_s, late):
    pace = Pace(factor, now=clock)
    clock.advance(STEP_S + behind_s)
    assert pace.delay_s(STEP_S) == 0.0
    # a long delay is not made up for
    assert pace.delay_s(STEP_S) == (STEP_S if late else 0.0)
    run(pace, clock, 5)
    assert is_late(pace, clock) is late
    assert not pace.is_to_report()


def test_a_pause_and_another_factor_are_not_made_up_for(clock):
    pace = Pace(1.0, now=clock)
    pace.pause()
    assert pace.is_paused
    clock.advance(300.0)
    pace.restart()
    pace.unpause()
    assert not pace.is_paused and pace.delay_s(STEP_S) == STEP_S
    clock.advance(300.0)
    pace.delay_s(STEP_S)
    pace.set_wanted(2.0)
    assert pace.wanted == 2.0 and pace.delay_s(STEP_S) == STEP_S / 2
    assert not is_late(pace, clock)


def test_factor_is_measured_per_second_and_the_last_one_is_kept(clock):
    pace, seen = Pace(1.0, now=clock), []
    for wall_s, simulated_s in ((0.5, 3.0), (0.5, 0.5), (0.5, 0.5), (0.5, 0.0), (0.5, 0.0),
                                (0.4375, 0.0), (4.0625, 1.25), (1.0, 0.0)):
        clock.advance(wall_s)
        seen.append((pace.measure(simulated_s), pace.measured))
    assert seen == [(None, 0.0), (3.5, 3.5), (None, 3.5), (0.5, 0.5), (None, 0.5), (None, 0.5),
                    (0.25, 0.25), (0.0, 0.0)]


def test_a_slow_machine_is_reported_once_then_when_it_is_worse_and_every_30_s(clock):
    pace = Pace(1.0, now=clock)
    factors = {2.0: 0.5, 4.0: 0.3, 6.0: 0.26, 8.0: 0.25, 10.0: 0.5, 37.25: 0.2, 38.0: 0.2,
               40.0: 0.4, 42.0: 0.11, 44.0: 0.1}
    reported, last_s = [], 0.0
    for time_s, factor in factors.items():
        clock.advance(time_s - last_s)
        pace.delay_s(STEP_S)
        assert not (pace.measured == 0.0 and pace.is_to_report())       # not measured yet
        pace.measure(factor * (time_s - last_s))
        last_s = time_s
        if pace.is_to_report():
            reported.append(time_s)
    assert reported == [2.0, 8.0, 38.0, 44.0]
    clock.advance(2.0)
    pace.measure(0.01)
    assert not pace.is_to_report()      # nothing was late since
