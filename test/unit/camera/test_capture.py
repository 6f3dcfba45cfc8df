"""The capture on fake sources and a fake clock, run in the thread of the test."""
from functools import partial, partialmethod

import numpy as np
import pytest

from img_recog.camera.capture import Capture, Listener
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError

IMAGE = np.zeros((2, 2, 3), np.uint8)


class FakeSource(FrameSource):
    """Performs steps: numbers are seconds until the next frame, exceptions are raised."""

    width = height = 2
    name, description = 'fake', 'a fake source'

    def __init__(self, clock, steps, **attributes):
        self._clock, self._steps = clock, list(steps)
        self.closed = 0
        for name, value in attributes.items():
            setattr(self, name, value)

    def read(self):
        step = self._steps.pop(0)
        if isinstance(step, Exception):
            raise step
        if callable(step):
            step = step() or 0.0
        self._clock.advance(step)
        return IMAGE

    def close(self):
        self.closed += 1


class Recorder(Listener):
    """Records the callbacks with their times; shuts down a capture that would wait for a start."""

    def __init__(self, clock):
        self._clock, self.calls = clock, []

    def record(self, name, *words):
        self.calls.append((name, *words, self._clock() - 100.0))
        if name in ('ended', 'failed'):
            assert not self.capture.wanted
            self.capture.shut_down()

    def opened(self, source):
        self.record('opened')

    def resized(self, source):
        self.record('resized', source.width)

    def frame(self, source, image):
        assert image is IMAGE
        self.record('frame')

    def failed(self, error, opening):
        self.record('failed', str(error), opening)

    skipped, dropped = partialmethod(record, 'skipped'), partialmethod(record, 'dropped')
    lost, reconnected = partialmethod(record, 'lost'), partialmethod(record, 'reconnected')
    ended, late = partialmethod(record, 'ended'), partialmethod(record, 'late')

    def names(self):
        return [call[0] for call in self.calls]


class Rig:
    """A capture with a fake clock, whose sources are opened one after the other."""

    def __init__(self, clock, *openings):
        self.clock, self._openings = clock, list(openings)
        self.listener = Recorder(clock)
        self.opened, self.waits, self.on_wait = [], [], lambda: None
        self.capture = Capture(self._open, self.listener, clock, self._wait)
        self.listener.capture = self.capture

    def source(self, *steps, **attributes):
        return FakeSource(self.clock, steps, **attributes)

    def _open(self):
        assert all(source.closed for source in self.opened), 'opened while another is open'
        if not self._openings:
            self.capture.shut_down()
            raise SourceError('no more openings')
        opening = self._openings.pop(0)
        if isinstance(opening, Exception):
            raise opening
        self.opened.append(self.source(*opening[0], **opening[1]))
        return self.opened[-1]

    def _wait(self, seconds):
        self.waits.append(round(seconds, 6))
        self.clock.advance(seconds)
        return bool(self.on_wait())

    def run(self):
        """Run until the openings are used up or the capture shuts down."""
        self.capture.start()
        self.capture.run()
        return self.listener.calls


GONE = SourceError('unplugged')


def device(*steps, **attributes):
    return steps, dict({'reconnects': True, 'stall_timeout_s': 1.5}, **attributes)


def video(*steps, **attributes):
    return steps, dict({'rate_hz': 8.0}, **attributes)


def test_frames_with_times_are_passed_on_at_them(clock):
    times = [0.0, 0.5, 0.53125, 0.5625, 1.0, 1.5]

    def read(number):
        rig.opened[-1].time_s = times[number]
        rig.opened[-1].step_s = times[number + 1] - times[number]
        return 0.0078125      # decoding, before which subscribers get time to receive
    rig = Rig(clock, video(*(partial(read, number) for number in range(5)), GONE, rate_hz=2.0))
    begin_s = 0.0078125
    assert [call for call in rig.run() if call[0] == 'frame'] == [
        ('frame', begin_s + time_s) for time_s in times[:5]]


def test_subscribers_get_a_frame_before_the_next_one_is_decoded(clock):
    begins = []

    def decode(seconds):
        begins.append(clock() - 100.0)
        return seconds
    quick, medium, slow, free = 0.015625, 0.046875, 0.0625, 0.0     # of a period of 0.125 s
    rig = Rig(clock, video(*(partial(decode, seconds) for seconds in (
        quick, medium, slow, slow, free, free)), SourceError('end')))
    rig.run()
    # a quarter of the period later, unless decoding takes half of it or longer, or no time
    assert begins == [0.0, 0.015625 + 0.03125, 0.140625 + 0.03125, 0.265625, 0.390625, 0.515625]
    assert [call[1] for call in rig.listener.calls if call[0] == 'frame'] == [
        0.015625 + 0.125 * number for number in range(6)]


def test_frames_that_are_late_are_counted_in_periods(clock):
    # each takes two and a half periods of 0.125 s
    rig = Rig(clock, video(*[0.3125] * 3, SourceError('end')))
    calls = rig.run()
    assert [call[1] for call in calls if call[0] == 'late'] == [1, 2]
    assert rig.listener.names().count('frame') == 3


@pytest.mark.parametrize('between, waits', [
    # from the start again after it was back
    ([SourceError('no such device')] * 6, [0.5, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0, 0.5]),
    # it opens, but gives no frame
    ([device(GONE)] * 2, [0.5, 1.0, 2.0, 0.5])])
def test_lost_device_is_reported_once_closed_and_retried_with_a_growing_delay(
        clock, between, waits):
    rig = Rig(clock, device(0.125, GONE), *between, device(0.125, GONE))
    calls = rig.run()
    assert [call[:2] for call in calls if call[0] == 'lost'] == [('lost', 'unplugged')] * 2
    assert rig.waits[:len(waits)] == waits
    assert rig.listener.names()[:6] == [
        'opened', 'frame', 'lost', 'opened', 'reconnected', 'frame']
    assert all(source.closed == 1 for source in rig.opened)


@pytest.mark.parametrize('timeout_s, said', [(1.5, '1.6'), (2.0, '2.1')])
def test_silent_device_is_detected_while_read_blocks(clock, timeout_s, said):
    seen = []

    def blocked():
        for seconds in (timeout_s, 0.125, 0.0):
            clock.advance(seconds)
            rig.capture.check()
            seen.append(rig.listener.names().count('lost'))
        assert rig.capture.wanted

    rig = Rig(clock, device(0.125, blocked, 0.125, GONE, stall_timeout_s=timeout_s))
    calls = rig.run()
    assert seen == [0, 1, 1]
    assert calls[2][:2] == ('lost', 'fake has given no frame for {} s'.format(said))
    assert rig.listener.names()[2:6] == ['lost', 'opened', 'reconnected', 'frame']


def test_source_without_a_timeout_is_never_stalled(clock):
    def slow():
        clock.advance(60.0)
        rig.capture.check()

    rig = Rig(clock, device(slow, GONE, stall_timeout_s=None))
    rig.run()
    assert rig.listener.names()[:3] == ['opened', 'frame', 'lost']


def test_check_between_reads_detects_nothing(clock):
    rig = Rig(clock, device(0.1, GONE))
    rig.capture.check()
    rig.listener.frame = lambda source, image: (clock.advance(9.0), rig.capture.check())
    rig.run()
    assert [call[1] for call in rig.listener.calls if call[0] == 'lost'] == ['unplugged']


@pytest.mark.parametrize('opening, calls', [
    # frames of a device are passed on as they arrive, and those of a video are paced
    (device(0.125, 0.25, 0.0625, SourceEnded('over')), [
        ('opened', 0.0), ('frame', 0.125), ('frame', 0.375), ('frame', 0.4375),
        ('ended', 'over', 0.4375)]),
    (video(0.0, 0.03125, 0.0, 0.0625, SourceEnded('over')), [
        ('opened', 0.0), ('frame', 0.0), ('frame', 0.125), ('frame', 0.25), ('frame', 0.375),
        ('ended', 'over', 0.375)]),
    (SourceError('missing'), [('failed', 'missing', True, 0.0)]),
    (video(0.0, SourceError('moved')), [
        ('opened', 0.0), ('frame', 0.0), ('failed', 'moved', False, 0.0)]),
    (video(0.0, SourceEnded('over')), [('opened', 0.0), ('frame', 0.0), ('ended', 'over', 0.0)]),
    (device(ValueError('bug')), [('opened', 0.0), ('failed', 'bug', False, 0.0)]),
    (video(0.0, FrameSkipped('empty'), 0.0, SourceEnded('over')), [     # it keeps the pace
        ('opened', 0.0), ('frame', 0.0), ('skipped', 'empty', 0.0), ('frame', 0.25),
        ('ended', 'over', 0.25)])])
def test_what_is_not_retried_ends_with_one_call_and_is_closed(clock, opening, calls):
    rig = Rig(clock, opening)
    assert rig.run() == calls
    assert [source.closed for source in rig.opened] == [1] * len(rig.opened)
    assert not [seconds for seconds in rig.waits if seconds >= 0.5]


OVER = SourceEnded('over')


def looping(*steps, **attributes):
    return video(*steps, OVER, loops=True, **attributes)


@pytest.mark.parametrize('again, calls', [
    # it is not opened again for the listener, and keeps the pace
    ([looping(0.03125, 0.0), SourceError('moved')], [
        ('frame', 0.25), ('frame', 0.375), ('failed', 'moved', False, 0.375)]),
    # another one now, of its own rate, and one with another size than the last frame had
    ([looping(0.0, description='other', width=3), SourceError('moved')], [
        ('opened', 0.125), ('frame', 0.25), ('failed', 'moved', False, 0.25)]),
    ([looping(0.0, width=3), SourceError('moved')], [
        ('resized', 3, 0.25), ('frame', 0.25), ('failed', 'moved', False, 0.25)]),
    # without a frame it would go on for ever
    ([looping()], [('ended', 'over', 0.125)])])
def test_a_source_that_loops_is_opened_again_at_its_end(clock, again, calls):
    rig = Rig(clock, looping(0.0, 0.0), *again)
    assert rig.run() == [('opened', 0.0), ('frame', 0.0), ('frame', 0.125), *calls]
    assert all(source.closed == 1 for source in rig.opened)
    assert not [seconds for seconds in rig.waits if seconds >= 0.5]


def test_the_times_of_a_film_go_on_when_it_starts_again(clock):
    def read(time_s):
        rig.opened[-1].time_s, rig.opened[-1].step_s = time_s, 0.25
    film = looping(*(partial(read, time_s) for time_s in (0.0, 0.5, 0.75)), rate_hz=2.0)
    rig = Rig(clock, film, film, film, SourceError('moved'))
    assert [call[1] for call in rig.run() if call[0] == 'frame'] == [
        0.0, 0.5, 0.75, 1.0, 1.5, 1.75, 2.0, 2.5, 2.75]


def test_a_source_that_cannot_be_opened_again_is_lost_if_it_reconnects(clock):
    film = looping(0.0, reconnects=True)
    rig = Rig(clock, film, SourceError('its server is gone'), film)
    rig.run()
    assert rig.listener.names() == ['opened', 'frame', 'lost', 'opened', 'reconnected', 'frame']
    assert 0.5 in rig.waits


def test_another_size_is_said_once_before_its_first_frame(clock):
    def grow():
        rig.opened[-1].width = 3
    rig = Rig(clock, device(0.125, grow, 0.125, SourceEnded('over')))
    assert rig.run() == [('opened', 0.0), ('frame', 0.125), ('resized', 3, 0.125),
                         ('frame', 0.125), ('frame', 0.25), ('ended', 'over', 0.25)]


def test_camera_above_its_max_rate_is_throttled_evenly(clock):
    rig = Rig(clock, device(*[1 / 64] * 640, GONE, max_hz=16.0))
    calls = rig.run()
    times = [call[1] for call in calls if call[0] == 'frame']
    assert {round((b - a) * 64) for a, b in zip(times[1:], times[2:])} == {4}
    assert len(times) + rig.listener.names().count('dropped') == 640


def test_shut_down_interrupts_the_wait_for_a_lost_device(clock):
    rig = Rig(clock, device(0.1, GONE), device(0.1))

    def on_wait():
        assert rig.listener.names()[-1] == 'lost' and rig.capture.wanted
        rig.capture.shut_down()
        return True
    rig.on_wait = on_wait
    rig.run()
    assert len(rig.opened) == 1 and rig.opened[0].closed == 1


def test_device_lost_after_a_stop_is_not_reported(clock):
    def stopped():
        rig.capture.shut_down()
        raise GONE

    rig = Rig(clock, device(0.1, stopped))
    rig.run()
    assert rig.listener.names() == ['opened', 'frame']
