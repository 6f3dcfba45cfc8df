"""The capture thread, run on fake sources: mostly in the test's own thread and on a fake clock."""
import os
import threading

import numpy as np
import pytest

from img_recog.camera.capture import Capture, Listener
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError
from img_recog_testing.waiting import wait_for

IMAGE = np.zeros((2, 2, 3), np.uint8)


class FakeSource(FrameSource):
    """Does the steps it is given: numbers are seconds until the next frame, the rest is raised."""

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
    """Writes down what it is told, with the time; ends a capture that would wait for a start."""

    def __init__(self, clock):
        self._clock, self.told = clock, []

    def _note(self, *what):
        self.told.append(what + (self._clock() - 100.0,))

    def opened(self, source):
        self._note('opened')

    def frame(self, source, image):
        assert image is IMAGE
        self._note('frame')

    def skipped(self, reason):
        self._note('skipped', reason)

    def dropped(self):
        self._note('left out')

    def lost(self, reason):
        self._note('lost', reason)

    def reconnected(self):
        self._note('reconnected')

    def ended(self, reason):
        self._note('ended', reason)
        self.capture.shut_down()

    def failed(self, error, opening):
        self._note('failed', str(error), opening)
        self.capture.shut_down()

    def kinds(self):
        return [entry[0] for entry in self.told]


class Rig:
    """A capture on a clock of its own, whose sources are opened one after the other."""

    def __init__(self, clock, *openings):
        self.clock, self._openings = clock, list(openings)
        self.listener = Recorder(clock)
        self.opened, self.waits = [], []
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
        return self.capture._stopping.is_set()

    def run(self):
        """Run until the openings are used up or the capture shuts down."""
        self.capture.start()
        self.capture.run()
        return self.listener.told


GONE = SourceError('unplugged')


def device(*steps, **attributes):
    return steps, dict({'reconnects': True, 'stall_timeout_s': 1.5}, **attributes)


def video(*steps, **attributes):
    return steps, dict({'rate_hz': 8.0}, **attributes)


def test_frames_of_a_device_come_as_they_are_read(clock):
    rig = Rig(clock, device(0.125, 0.25, 0.0625, GONE))
    assert rig.run()[:4] == [('opened', 0.0), ('frame', 0.125), ('frame', 0.375),
                             ('frame', 0.4375)]


def test_frames_of_a_video_are_paced(clock):
    rig = Rig(clock, video(0.0, 0.03125, 0.0, 0.0625, SourceError('end')))
    rig.run()
    assert [entry for entry in rig.listener.told if entry[0] == 'frame'] == [
        ('frame', 0.0), ('frame', 0.125), ('frame', 0.25), ('frame', 0.375)]


def test_lost_device_is_told_once_closed_first_and_tried_again_ever_less_often(clock):
    missing = [SourceError('no such device')] * 6
    rig = Rig(clock, device(0.125, GONE), *missing, device(0.125, GONE))
    told = rig.run()
    assert [entry[:2] for entry in told if entry[0] == 'lost'] == [
        ('lost', 'unplugged'), ('lost', 'unplugged')]
    assert rig.waits[:7] == [0.5, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0]
    assert rig.waits[7] == 0.5      # from the start again after it was back
    assert rig.listener.kinds()[:6] == [
        'opened', 'frame', 'lost', 'opened', 'reconnected', 'frame']
    assert [source.closed for source in rig.opened] == [1, 1]


def test_device_that_opens_but_gives_nothing_is_not_called_back(clock):
    rig = Rig(clock, device(0.125, GONE), device(GONE), device(GONE), device(0.125, GONE))
    rig.run()
    assert rig.listener.kinds()[:6] == [
        'opened', 'frame', 'lost', 'opened', 'reconnected', 'frame']
    assert rig.waits[:3] == [0.5, 1.0, 2.0]


def test_silent_device_is_noticed_while_read_blocks(clock):
    seen = []

    def blocked():
        clock.advance(1.4)
        rig.capture.check()
        seen.append(rig.listener.kinds().count('lost'))
        clock.advance(0.2)
        rig.capture.check()
        rig.capture.check()
        seen.append(rig.listener.kinds().count('lost'))

    rig = Rig(clock, device(0.125, blocked, 0.125, GONE))
    told = rig.run()
    assert seen == [0, 1]
    assert told[2][:2] == ('lost', 'fake has given no frame for 1.6 s')
    assert rig.listener.kinds()[2:6] == ['lost', 'opened', 'reconnected', 'frame']


def test_source_that_may_be_slow_is_not_called_silent(clock):
    def slow():
        clock.advance(60.0)
        rig.capture.check()

    rig = Rig(clock, device(slow, GONE, stall_timeout_s=None))
    rig.run()
    assert rig.listener.kinds()[:3] == ['opened', 'frame', 'lost']


def test_check_between_reads_finds_nothing(clock):
    rig = Rig(clock, device(0.1, GONE))
    rig.capture.check()
    rig.listener.frame = lambda source, image: (clock.advance(9.0), rig.capture.check())
    rig.run()
    assert [entry[1] for entry in rig.listener.told if entry[0] == 'lost'] == ['unplugged']


def test_device_that_is_missing_at_the_start_is_not_waited_for(clock):
    rig = Rig(clock, SourceError('cannot open'))
    assert rig.run() == [('failed', 'cannot open', True, 0.0)]
    assert rig.waits == []


def test_video_that_vanishes_ends_the_capture(clock):
    rig = Rig(clock, video(0.0, SourceError('moved')))
    assert rig.run()[-1] == ('failed', 'moved', False, 0.0)
    assert not rig.capture.is_lost and rig.opened[0].closed == 1


def test_end_of_a_video_is_told_once_and_closes_it(clock):
    rig = Rig(clock, video(0.0, SourceEnded('over')))
    assert [entry[0] for entry in rig.run()] == ['opened', 'frame', 'ended']
    assert rig.opened[0].closed == 1


def test_error_that_nobody_expected_is_handed_over(clock):
    rig = Rig(clock, device(ValueError('bug')))
    assert rig.run()[-1][:3] == ('failed', 'bug', False)
    assert rig.opened[0].closed == 1


def test_empty_frame_is_skipped_and_keeps_the_pace(clock):
    rig = Rig(clock, video(0.0, FrameSkipped('empty'), 0.0, SourceError('end')))
    assert [(entry[0], entry[-1]) for entry in rig.run()][:4] == [
        ('opened', 0.0), ('frame', 0.0), ('skipped', 0.0), ('frame', 0.25)]


def test_camera_that_gives_more_than_asked_for_is_throttled_evenly(clock):
    rig = Rig(clock, device(*[1 / 64] * 640, GONE, max_hz=16.0))
    told = rig.run()
    times = [entry[1] for entry in told if entry[0] == 'frame']
    assert {round((b - a) * 64) for a, b in zip(times[1:], times[2:])} == {4}
    assert len(times) + rig.listener.kinds().count('left out') == 640


def test_camera_at_about_its_rate_is_let_through_whole(clock):
    rig = Rig(clock, device(*[1 / 30.5, 1 / 30.1] * 300, GONE, max_hz=30.0))
    rig.run()
    assert rig.listener.kinds().count('frame') == 600


def test_shut_down_ends_the_wait_for_a_lost_device(clock):
    rig = Rig(clock, device(0.1, GONE), device(0.1))

    def wait(seconds):
        assert rig.capture.is_lost and rig.capture.wanted
        rig.capture.shut_down()
        return True
    rig.capture._wait = wait
    rig.run()
    assert len(rig.opened) == 1 and rig.opened[0].closed == 1


def test_device_lost_after_stop_was_asked_for_is_no_news(clock):
    def stopped():
        rig.capture.shut_down()
        raise GONE

    rig = Rig(clock, device(0.1, stopped))
    rig.run()
    assert rig.listener.kinds() == ['opened', 'frame'] and not rig.capture.is_lost


class RealFile(FrameSource):
    """Holds a file descriptor and gives a frame each millisecond until it is told to block."""

    width = height = 2
    name = description = 'real'
    reconnects, stall_timeout_s = True, 0.05

    def __init__(self, blocking):
        self._blocking, self._descriptor = blocking, os.open('/dev/null', os.O_RDONLY)

    def read(self):
        while self._blocking.is_set():
            threading.Event().wait(0.001)
        threading.Event().wait(0.001)
        return IMAGE

    def close(self):
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)


class Counter(Listener):
    """Counts frames, losses and returns."""

    def __init__(self):
        self.frames = self.losses = self.returns = 0

    def frame(self, source, image):
        self.frames += 1

    def lost(self, reason):
        self.losses += 1

    def reconnected(self):
        self.returns += 1


@pytest.fixture
def running():
    """A capture in a thread of its own, its listener, and the switch that blocks its source."""
    blocking, listener = threading.Event(), Counter()
    capture = Capture(lambda: RealFile(blocking), listener)
    capture.start_thread()
    yield capture, listener, blocking
    blocking.clear()
    capture.shut_down()


def test_twenty_rounds_of_start_and_stop_leave_no_descriptor(running):
    capture, listener, _ = running
    before = len(os.listdir('/proc/self/fd'))
    for _ in range(20):
        count = listener.frames
        capture.start()
        capture.start()
        wait_for(lambda: listener.frames > count, 'a frame')
        assert len(os.listdir('/proc/self/fd')) == before + 1
        assert capture.stop() and capture.stop()
        assert len(os.listdir('/proc/self/fd')) == before
    assert capture.shut_down()


def test_stop_before_start_is_done_at_once(running):
    capture, listener, _ = running
    assert capture.stop()
    assert not capture.wanted and listener.frames == 0


def test_blocked_source_is_told_and_goes_on(running):
    capture, listener, blocking = running
    capture.start()
    wait_for(lambda: listener.frames > 0, 'a frame')
    blocking.set()
    wait_for(lambda: capture.check() or listener.losses, 'the loss')
    assert capture.is_lost
    blocking.clear()
    wait_for(lambda: listener.returns, 'the return')
    assert (listener.losses, listener.returns, capture.is_lost) == (1, 1, False)


def test_owner_is_not_held_up_by_a_source_that_blocks(running, monkeypatch):
    monkeypatch.setattr('img_recog.camera.capture._STOP_TIMEOUT_S', 0.05)
    monkeypatch.setattr('img_recog.camera.capture._JOIN_TIMEOUT_S', 0.05)
    capture, listener, blocking = running
    capture.start()
    wait_for(lambda: listener.frames > 0, 'a frame')
    blocking.set()
    wait_for(lambda: capture.check() or listener.losses, 'the loss')
    assert not capture.stop()
    assert not capture.shut_down()
    blocking.clear()
    wait_for(capture.shut_down, 'the end of the thread')


def test_start_after_shut_down_does_nothing(running):
    capture, listener, _ = running
    assert capture.shut_down()
    capture.start()
    assert listener.frames == 0 and not capture._thread.is_alive()
