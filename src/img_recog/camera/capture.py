"""A thread that reads frames from a source, detects a stall, and reopens a lost source."""
import threading
import time
from typing import Callable, Optional, Tuple

import numpy as np

from img_recog.camera.frame_pacing import Pacer, RateLimit
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError

FIRST_RETRY_S, LAST_RETRY_S = 0.5, 5.0
_STOP_TIMEOUT_S, _JOIN_TIMEOUT_S = 1.5, 1.0     # a read may block for longer
# Subscribers receive a frame in this share of its period, before the next one is decoded: they may
# wait for the processor otherwise. Not if decoding takes a larger share than the other one, or
# hardly any time.
_RECEIVING_SHARE, _MAX_READING_SHARE, _NOTHING_S = 0.25, 0.5, 2e-4


class Listener:
    """Callbacks of a capture, in its thread; `lost` also in the thread that calls `check`."""

    def opened(self, source: FrameSource) -> None:
        """A source is open; also called when a lost source is back."""

    def resized(self, source: FrameSource) -> None:
        """The next frame has another size than the one before."""

    def frame(self, source: FrameSource, image: np.ndarray) -> None:
        """A frame was captured, `source.age_s` ago."""

    def skipped(self, reason: str) -> None:
        """A frame could not be used."""

    def dropped(self) -> None:
        """A frame was dropped because the source exceeds its `max_hz`."""

    def late(self, periods: int) -> None:
        """A frame is late by whole periods, and with it all that follow."""

    def lost(self, reason: str) -> None:
        """A source gives no more frames and will be reopened; called once for each loss."""

    def reconnected(self) -> None:
        """A lost source gives frames again."""

    def ended(self, reason: str) -> None:
        """A source has given all its frames; the capture is stopped."""

    def failed(self, error: Exception, opening: bool) -> None:
        """A source failed and will not be reopened; the capture is stopped.

        opening: whether it failed to open, or else while it was read.
        """


class Capture:
    """Reads frames in a thread between `start` and `stop`, and passes them to a listener.

    A source that has `reconnects` set, and that was open before, is reopened whenever it is lost:
    it is closed first, and retried with a delay that grows from 0.5 s to 5 s. One that `loops` is
    reopened when it has ended, too; seeking would be inexact in many films.
    """

    def __init__(self, open_source: Callable[[], FrameSource], listener: Listener,
                 now: Callable[[], float] = time.monotonic,
                 wait: Optional[Callable[[float], bool]] = None):
        """Create a capture that is stopped.

        open_source: opens the source, each time anew; raises SourceError when it fails.
        now: returns the seconds of a steady clock.
        wait: sleeps for at most the given seconds; returns whether the capture has to stop.
        """
        self._open_source, self._listener, self._now = open_source, listener, now
        self._wanted, self._stopping, self._closed = (threading.Event() for _ in range(3))
        self._closed.set()
        self._wait = wait or self._stopping.wait
        self._lock = threading.Lock()
        self._shut_down = self._reconnects = self._lost = False
        self._ended: Optional[FrameSource] = None       # that loops, and is about to start again
        self._pacer: Optional[Pacer] = None
        self._reading: Optional[FrameSource] = None
        self._reading_since = 0.0
        self._thread: Optional[threading.Thread] = None

    @property
    def wanted(self) -> bool:
        """Whether it is started: reading frames, or waiting for a lost source."""
        return self._wanted.is_set()

    def start_thread(self) -> None:
        """Start the thread; it reads nothing before `start`."""
        self._thread = threading.Thread(target=self.run, name='capture', daemon=True)
        self._thread.start()

    def start(self) -> None:
        """Open the source and read frames; no effect when it is started already."""
        with self._lock:
            if not self._shut_down:
                self._stopping.clear()
                self._wanted.set()

    def stop(self) -> bool:
        """Stop reading and close the source; no effect when it is stopped already.

        Returns whether the source is closed: it waits for at most 1.5 s, and a source that blocks
        is closed as soon as its read returns.
        """
        self._request_stop()
        return self._closed.wait(_STOP_TIMEOUT_S)

    def shut_down(self) -> bool:
        """Stop for good; return whether the thread has ended, after at most 1 s."""
        with self._lock:
            self._shut_down = True
            self._stopping.set()
            self._wanted.set()      # wakes the thread
        if self._thread is None:
            return True
        self._thread.join(_JOIN_TIMEOUT_S)
        return not self._thread.is_alive()

    def check(self) -> None:
        """Detect a stalled source; the owner has to call this several times a second."""
        with self._lock:
            source, since = self._reading, self._reading_since
        if source is None or source.stall_timeout_s is None:
            return
        silent_s = self._now() - since
        if silent_s > source.stall_timeout_s:
            self._set_lost('{} has given no frame for {:.1f} s'.format(source.name, silent_s))

    def run(self) -> None:
        """Read frames until `shut_down` is called: the body of the thread."""
        while True:
            self._wanted.wait()
            if self._shut_down:
                return
            self._closed.clear()
            try:
                self._capture()
            except Exception as error:      # whatever it is, the listener has to know
                self._request_stop()
                self._listener.failed(error, opening=False)
            finally:
                self._closed.set()

    def _request_stop(self) -> None:
        with self._lock:
            if not self._shut_down:
                self._wanted.clear()
            self._stopping.set()

    def _capture(self) -> None:
        retry_s, self._ended = FIRST_RETRY_S, None
        while not self._stopping.is_set():
            try:
                source = self._open_source()
            except SourceError as error:
                if not self._reconnects:
                    self._request_stop()
                    self._listener.failed(error, opening=self._ended is None)
                    return
                self._ended = None
                self._set_lost(str(error))
            else:
                self._reconnects = source.reconnects
                if self._read_all(source):
                    retry_s = FIRST_RETRY_S
                if self._ended is not None:
                    continue
            if self._pause(retry_s):
                return
            retry_s = min(2.0 * retry_s, LAST_RETRY_S)

    def _read_all(self, source: FrameSource) -> bool:
        """Pass on frames until the source ends or fails; return whether there was any frame."""
        any_frame = False
        try:
            size = self._begin(source)
            limit = RateLimit(source.max_hz) if source.max_hz else None
            period_s = 1.0 / source.rate_hz if source.rate_hz else 0.0
            read_s = 0.0
            while not self._stopping.is_set():
                if (_NOTHING_S < read_s < _MAX_READING_SHARE * period_s
                        and self._pause(_RECEIVING_SHARE * period_s)):
                    break
                begin_s = self._now()
                image = self._read(source)
                read_s = self._now() - begin_s
                period_s = source.step_s or period_s
                if image is not None and limit is not None and not limit.accepts(
                        self._now() - source.age_s):
                    self._listener.dropped()
                    continue
                if self._pacer is not None:
                    late, delay_s = self._pacer.late, self._pacer.delay_s(source.time_s)
                    if self._pacer.late > late:
                        self._listener.late(self._pacer.late - late)
                    if self._pause(delay_s):
                        break
                if image is not None:
                    any_frame = True
                    self._clear_lost(source)
                    if size != (source.width, source.height):
                        size = source.width, source.height
                        self._listener.resized(source)
                    self._listener.frame(source, image)
        except SourceEnded as end:
            if source.loops and any_frame:
                self._ended = source
            else:
                self._request_stop()
                self._listener.ended(str(end))
        except SourceError as error:
            if source.reconnects:
                self._set_lost(str(error))
            else:
                self._request_stop()
                self._listener.failed(error, opening=False)
        finally:
            # before it is reopened: a device that returns while it is still open gets a new name
            source.close()
        return any_frame

    def _begin(self, source: FrameSource) -> Tuple[int, int]:
        """Begin to read a source that is open; return the size of the frames before."""
        before, self._ended = self._ended, None
        if before is None or self._pacer is None or not source.rate_hz:
            self._pacer = Pacer(source.rate_hz, self._now) if source.rate_hz else None
        else:
            self._pacer.restart(before.step_s or 1.0 / source.rate_hz)
        if before is not None and before.description == source.description:
            return before.width, before.height
        if not self._lost:
            self._listener.opened(source)
        return source.width, source.height

    def _read(self, source: FrameSource) -> Optional[np.ndarray]:
        """Return the next frame, or None when it cannot be used."""
        with self._lock:
            self._reading, self._reading_since = source, self._now()
        try:
            return source.read()
        except FrameSkipped as skipped:
            self._listener.skipped(str(skipped))
            return None
        finally:
            with self._lock:
                self._reading = None

    def _pause(self, seconds: float) -> bool:
        """Wait; return whether to stop."""
        return self._stopping.is_set() or (seconds > 0.0 and self._wait(seconds))

    def _set_lost(self, reason: str) -> None:
        with self._lock:
            newly_lost = not self._lost and not self._stopping.is_set()
            self._lost = self._lost or newly_lost
        if newly_lost:
            self._listener.lost(reason)

    def _clear_lost(self, source: FrameSource) -> None:
        with self._lock:
            was_lost, self._lost = self._lost, False
        if was_lost:
            self._listener.opened(source)
            self._listener.reconnected()
