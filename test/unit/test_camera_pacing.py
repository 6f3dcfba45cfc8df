"""The camera's pacer on a clock that the test moves."""
import pytest

from img_recog.camera.pacing import Pacer

# binary fractions, so that the expected times are exact
RATE_HZ, PERIOD_S = 8.0, 0.125


@pytest.fixture
def pacer(clock):
    return Pacer(RATE_HZ, now=clock)


def test_first_frame_is_due_at_once(pacer):
    assert pacer.delay_s() == 0.0


def test_deadlines_are_multiples_of_the_period_whatever_the_work_takes(pacer, clock):
    start, times = clock.now_s, []
    for work_s in (0.0, 0.03125, 0.0625, 0.09375, 0.125, 0.015625) * 50:
        clock.advance(pacer.delay_s())
        times.append(clock.now_s - start)
        clock.advance(work_s)
    assert times == [number * PERIOD_S for number in range(300)]


def test_no_drift_at_a_rate_that_is_no_binary_fraction(clock):
    pacer, start = Pacer(30.0, now=clock), clock.now_s
    for _ in range(30000):
        clock.advance(pacer.delay_s())
        taken_s = clock.now_s - start
        clock.advance(0.004)
    assert taken_s == pytest.approx(29999 / 30.0, abs=1e-6)


def test_lateness_of_less_than_a_period_is_caught_up_with(pacer, clock):
    pacer.delay_s()
    clock.advance(PERIOD_S + 0.09375)
    assert pacer.delay_s() == 0.0
    assert pacer.delay_s() == 0.03125


@pytest.mark.parametrize('missed', [1, 2, 7, 1000])
def test_no_burst_after_a_frame_late_by_more_than_a_period(pacer, clock, missed):
    pacer.delay_s()
    clock.advance((1 + missed) * PERIOD_S + 0.03125)
    assert pacer.delay_s() == 0.0
    assert pacer.delay_s() == PERIOD_S - 0.03125        # back on the grid of the first frame
    clock.advance(PERIOD_S - 0.03125)
    assert pacer.delay_s() == PERIOD_S


def test_waiting_too_long_by_little_does_not_add_up(pacer, clock):
    start = clock.now_s
    for _ in range(100):
        clock.advance(pacer.delay_s() + 0.015625)
    assert clock.now_s - start == 99 * PERIOD_S + 0.015625
