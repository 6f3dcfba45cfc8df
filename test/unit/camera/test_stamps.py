"""Stamps by clocks that run, stop and jump."""
import pytest

from img_recog.camera.stamps import Stamps


def stamps_of(*readings):
    stamps = Stamps()
    return [stamps.stamp_ns(now_ns, age_s) for now_ns, age_s in readings]


def test_stamp_is_the_time_minus_the_age():
    assert stamps_of((5 * 10 ** 9, 0.0), (6 * 10 ** 9, 0.25)) == [5 * 10 ** 9, 5750000000]


def test_age_is_in_seconds_and_zero_if_it_is_not_given():
    assert Stamps().stamp_ns(5) == 5
    assert stamps_of((10 ** 12, 16.0)) == [984 * 10 ** 9]


def test_clock_that_is_stopped():
    assert stamps_of((7, 0.0), (7, 0.0), (7, 0.0), (9, 0.0), (10, 0.0)) == [7, 8, 9, 10, 11]


def test_ages_that_would_reverse_the_order():
    assert stamps_of((10 ** 9, 0.0), (10 ** 9 + 5, 0.5), (2 * 10 ** 9, 0.5)) == [
        10 ** 9, 10 ** 9 + 1, 15 * 10 ** 8]


def test_stamps_follow_a_clock_that_jumps_back():
    assert stamps_of((900, 0.0), (5, 0.0), (5, 0.0), (8, 0.0)) == [900, 5, 6, 8]


@pytest.mark.parametrize('age_s', [1.0, 1e-9])
def test_no_stamp_before_the_epoch(age_s):
    assert stamps_of((0, age_s)) == [0]
