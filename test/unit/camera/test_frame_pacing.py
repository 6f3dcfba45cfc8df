"""Pacing and throttling on a fake clock, and stamps by clocks that run, stop and jump."""
import pytest

from img_recog.camera.frame_pacing import Pacer, RateLimit, Stamps

# binary fractions, so that the expected times are exact
RATE_HZ, PERIOD_S = 8.0, 0.125


@pytest.fixture
def pacer(clock):
    return Pacer(RATE_HZ, now=clock)


def test_deadlines_are_multiples_of_the_period(pacer, clock):
    start, times = clock.now_s, []
    for work_s in (0.0, 0.03125, 0.0625, 0.09375, 0.125, 0.015625) * 50:
        clock.advance(pacer.delay_s())
        times.append(clock.now_s - start)
        clock.advance(work_s)
    assert times == [number * PERIOD_S for number in range(300)]


def test_no_drift_at_a_rate_that_is_not_a_binary_fraction(clock):
    pacer, start = Pacer(30.0, now=clock), clock.now_s
    for _ in range(30000):
        clock.advance(pacer.delay_s())
        elapsed_s = clock.now_s - start
        clock.advance(0.004)
    assert elapsed_s == pytest.approx(29999 / 30.0, abs=1e-6)


# the seconds before a frame, its time if it has one, and the delay
@pytest.mark.parametrize('steps', [
    # late by at most a period: that is caught up
    *([(0.0, None, 0.0), (PERIOD_S + late_s, None, 0.0), (0.0, None, PERIOD_S - late_s)]
      for late_s in (0.09375, PERIOD_S)),
    # by more: no burst, and the deadlines are multiples of the period
    *([(0.0, None, 0.0), ((1 + missed) * PERIOD_S + 0.03125, None, 0.0),
       (0.0, None, PERIOD_S - 0.03125), (PERIOD_S - 0.03125, None, PERIOD_S)]
      for missed in (1, 2, 7, 1000)),
    # frames with times are due at them; one that is late by 8 periods makes all after it late
    [(0.0, 0.0, 0.0), (0.0, 0.5, 0.5), (0.5, 0.53125, 0.03125), (0.03125, 2.0, 1.46875),
     (2.5, 2.03125, 0.0), (0.0, 2.5, 0.46875)]])
def test_delays(pacer, clock, steps):
    for before_s, time_s, delay_s in steps:
        clock.advance(before_s)
        assert pacer.delay_s(time_s) == delay_s


def kept(intervals, rate_hz):
    """Return the numbers of the frames that are kept, given the intervals between all frames."""
    limit, now_s, numbers = RateLimit(rate_hz), 0.0, []
    for number, interval_s in enumerate(intervals):
        now_s += interval_s
        if limit.accepts(now_s):
            numbers.append(number)
    return numbers


@pytest.mark.parametrize('given_hz, wanted_hz, steps', [
    (64.0, 32.0, {2}), (64.0, 16.0, {4}), (30.0, 10.0, {3}), (30.0, 20.0, {1, 2}),
    (60.0, 25.0, {2, 3}), (120.0, 1.0, {120})])
def test_frames_are_dropped_evenly(given_hz, wanted_hz, steps):
    numbers = kept([1.0 / given_hz] * 1200, wanted_hz)
    assert len(numbers) == pytest.approx(1200 * wanted_hz / given_hz, abs=2)
    # without the first few, until the rate is known
    assert {b - a for a, b in zip(numbers[3:], numbers[4:])} == steps


@pytest.mark.parametrize('intervals, count', [
    ([0.010, 0.023, 0.017, 0.0166] * 300, 600), ([1 / 60] * 120 + [10.0] + [1 / 60] * 120, 121)])
def test_neither_jitter_nor_a_pause_changes_the_rate(intervals, count):
    assert len(kept(intervals, 30.0)) == pytest.approx(count, abs=3)


@pytest.mark.parametrize('given_hz, keeps_all', [
    (5.0, True), (29.97, True), (30.0, True), (31.5, True), (31.65, False), (32.0, False)])
def test_camera_may_exceed_its_rate_by_five_percent(given_hz, keeps_all):
    numbers = kept([1.0 / given_hz] * 2000, 30.0)
    assert (numbers == list(range(2000))) is keeps_all


def test_first_frames_are_kept_by_their_interval():
    limit = RateLimit(8.0)
    assert limit.accepts(0.0)
    # the next is due at 0.125, and nearest to it is the one at 0.125
    assert [limit.accepts(time_s) for time_s in (0.03125, 0.0625, 0.09375, 0.125)] == [
        False, False, False, True]
    # not before half an interval ahead of the due time 0.25
    assert [limit.accepts(time_s) for time_s in (0.203125, 0.234375, 0.265625)] == [
        False, True, False]


@pytest.mark.parametrize('readings, stamps', [
    ([(5 * 10 ** 9,), (6 * 10 ** 9, 0.25)], [5 * 10 ** 9, 5750000000]),
    ([(10 ** 12, 16.0)], [984 * 10 ** 9]),
    ([(7,), (7,), (7,), (9,), (10,)], [7, 8, 9, 10, 11]),                   # it is stopped
    # ages that would reverse the order
    ([(10 ** 9,), (10 ** 9 + 5, 0.5), (2 * 10 ** 9, 0.5)], [10 ** 9, 10 ** 9 + 1, 15 * 10 ** 8]),
    ([(900,), (5,), (5,), (8,)], [900, 5, 6, 8]),                           # it jumps back
    ([(0, 1.0)], [0]), ([(0, 1e-9)], [0])])
def test_stamps_are_the_time_minus_the_age_and_increase(readings, stamps):
    made = Stamps()
    assert [made.stamp_ns(*reading) for reading in readings] == stamps
