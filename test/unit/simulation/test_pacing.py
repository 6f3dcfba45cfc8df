"""Pacing, the measured factor and its reports with a fake clock."""
import pytest

from img_recog.simulation.pacing import RealTimeFactor, RealTimePacer, SlowReports

# a binary fraction, so that the expected times are exact
STEP_S = 0.0625


def run(pacer, clock, steps, work_s=0.0):
    """Simulate steps that take `work_s` each, wait after each one; return the wall time."""
    start = clock.now_s
    for _ in range(steps):
        clock.advance(work_s)
        clock.advance(pacer.delay_s(STEP_S))
    return clock.now_s - start


@pytest.mark.parametrize('factor, wall_s', [(1.0, 10.0), (2.0, 5.0), (0.5, 20.0), (0.0, 0.0)])
def test_simulated_time_passes_at_the_factor(clock, factor, wall_s):
    pacer = RealTimePacer(factor, now=clock)
    assert run(pacer, clock, 160) == wall_s
    assert not pacer.late


def test_work_is_part_of_the_time(clock):
    pacer = RealTimePacer(1.0, now=clock)
    assert run(pacer, clock, 160, work_s=0.03125) == 10.0
    assert not pacer.late


def test_delay_is_what_is_left_of_the_step(clock):
    pacer = RealTimePacer(2.0, now=clock)
    clock.advance(0.0078125)
    assert pacer.delay_s(STEP_S) == STEP_S / 2 - 0.0078125


def test_factor_zero_never_waits_and_is_never_late(clock):
    pacer = RealTimePacer(0.0, now=clock)
    clock.advance(3600.0)
    assert pacer.delay_s(STEP_S) == 0.0
    assert not pacer.late


def test_a_short_delay_is_made_up_for(clock):
    pacer, start = RealTimePacer(1.0, now=clock), clock.now_s
    clock.advance(0.5)
    assert [pacer.delay_s(STEP_S) for _ in range(8)] == [0.0] * 8
    assert pacer.delay_s(STEP_S) == STEP_S
    assert not pacer.late
    assert clock.now_s - start == 0.5


@pytest.mark.parametrize('behind_s, late', [(0.5, False), (0.50390625, True), (60.0, True)])
def test_late_flag_is_set_after_more_than_half_a_second(clock, behind_s, late):
    pacer = RealTimePacer(1.0, now=clock)
    clock.advance(STEP_S + behind_s)
    assert pacer.delay_s(STEP_S) == 0.0
    assert pacer.late is late


def test_a_long_delay_is_not_made_up_for(clock):
    pacer = RealTimePacer(1.0, now=clock)
    clock.advance(60.0)
    assert pacer.delay_s(STEP_S) == 0.0
    assert pacer.delay_s(STEP_S) == STEP_S


def test_late_flag_stays_until_cleared(clock):
    pacer = RealTimePacer(1.0, now=clock)
    clock.advance(60.0)
    run(pacer, clock, 5)
    assert pacer.late
    pacer.late = False
    run(pacer, clock, 5)
    assert not pacer.late


def test_after_restart_a_pause_is_not_made_up_for(clock):
    pacer = RealTimePacer(1.0, now=clock)
    run(pacer, clock, 5)
    clock.advance(300.0)
    pacer.restart()
    assert pacer.delay_s(STEP_S) == STEP_S
    assert not pacer.late


def test_factor_is_none_until_a_second_is_over(clock):
    factor = RealTimeFactor(now=clock)
    for _ in range(15):
        clock.advance(STEP_S)
        assert factor.update(STEP_S / 2) is None
    assert factor.last == 0.0
    clock.advance(STEP_S)
    assert factor.update(STEP_S / 2) == 0.5
    assert factor.last == 0.5


def test_factor_is_relative_to_the_elapsed_wall_time(clock):
    factor = RealTimeFactor(now=clock)
    clock.advance(4.0)
    assert factor.update(1.0) == 0.25


def test_factor_is_measured_per_second_and_the_last_one_is_kept(clock):
    factor, seen = RealTimeFactor(now=clock), []
    for simulated_s in (3.0, 0.5, 0.5, 0.0, 0.0):
        clock.advance(0.5)
        seen.append((factor.update(simulated_s), factor.last))
    assert seen == [(None, 0.0), (3.5, 3.5), (None, 3.5), (0.5, 0.5), (None, 0.5)]


def test_factor_is_zero_when_paused(clock):
    factor = RealTimeFactor(now=clock)
    clock.advance(1.0)
    assert factor.update(1.0) == 1.0
    clock.advance(1.0)
    assert factor.update(0.0) == 0.0
    assert factor.last == 0.0


def test_a_slow_machine_is_reported_once_then_when_it_is_worse_and_every_30_s(clock):
    reports = SlowReports(clock)
    factors = {0.0: 0.5, 1.0: 0.3, 2.0: 0.26, 3.0: 0.25, 4.0: 0.5, 32.9: 0.2, 33.0: 0.4,
               62.9: 0.21, 62.99: 0.2}
    reported, last_s = [], 0.0
    for time_s, factor in factors.items():
        clock.advance(time_s - last_s)
        last_s = time_s
        if reports.ready(factor):
            reported.append(time_s)
    assert reported == [0.0, 3.0, 33.0, 62.99]
