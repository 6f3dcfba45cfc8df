"""A thread that captures from a source, notices when it falls silent, and waits for its return."""
import threading
import time
from typing import Callable, Optional

import numpy as np

from img_recog.camera.pacing import Pacer, Throttle
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError

FIRST_RETRY_S, LAST_RETRY_S = 0.5, 5.0
# how long the owner waits for a source that blocks
_STOPPING_S, _SHUT_DOWN_S = 1.5, 1.0


class Listener:
    """What a capture tells: in its own thread, but `lost` also in that of who calls `check`."""

    def opened(self, source: FrameSource) -> None:
        """A source is open and about to give frames; also one that has come back."""

    def frame(self, source: FrameSource, image: np.ndarray) -> None:
        """A frame was captured, `source.age_s` ago."""

    def skipped(self, reason: str) -> None:
        """A frame could not be used."""

    def dropped(self) -> None:
        """A frame was left out, since the source gives more than its `max_hz`."""

    def lost(self, reason: str) -> None:
        """A source gives no more frames, and its return is waited for; told once."""

    def reconnected(self) -> None:
        """A lost source gives frames again."""

    def ended(self, reason: str) -> None:
        """A source has given all its frames; the capture is stopped."""

    def failed(self, error: Exception, opening: bool) -> None:
        """A source cannot be used and is not waited for; the capture is stopped.

        opening: it could not be opened; else it gave frames before.
        """


class Capture:
    """Captures in a thread of its own while it is wanted, and tells a listener what comes.

    A source that says of itself that it reconnects, and that was open once, is waited for
    whenever it is gone: it is closed, and opened again with a pause that grows from half a second
    to five.
    """

    def __init__(self, open_source: Callable[[], FrameSource], listener: Listener,
                 now: Callable[[], float] = time.monotonic,
                 wait: Optional[Callable[[float], bool]] = None):
        """Capture nothing yet.

        open_source: opens the source anew each time; raises SourceError when it cannot.
        now: seconds of a steady clock.
        wait: sleeps for some seconds, or less; returns whether the capture shall stop.
        """
        self._open_source, self._listener, self._now = open_source, listener, now
        self._wanted, self._stopping, self._closed = (threading.Event() for _ in range(3))
        self._stopping.set()
        self._closed.set()
        self._wait = wait or self._stopping.wait
        self._lock = threading.Lock()
        self._ended = self._known = self._lost = False
        self._reading: Optional[FrameSource] = None
        self._reading_since = 0.0
        self._thread: Optional[threading.Thread] = None

    @property
    def wanted(self) -> bool:
        """Whether it captures, or waits for the return of a source."""
        return self._wanted.is_set()

    @property
    def is_lost(self) -> bool:
        """Whether the source is gone and waited for."""
        return self._lost

    def begin(self) -> None:
        """Start the thread."""
        self._thread = threading.Thread(target=self.run, name='capture', daemon=True)
        self._thread.start()

    def start(self) -> None:
        """Open the source and capture; harmless when repeated."""
        with self._lock:
            if not self._ended:
                self._stopping.clear()
                self._wanted.set()

    def stop(self) -> bool:
        """Stop capturing and close the source; harmless when repeated.

        Returns whether the source is closed: after one and a half seconds it returns all the
        same, and a source that blocks is closed as soon as it does no more.
        """
        self._request_stop()
        return self._closed.wait(_STOPPING_S)

    def shut_down(self) -> bool:
        """Stop for good; return whether the thread has ended, after 1 s at the latest."""
        with self._lock:
            self._ended = True
            self._stopping.set()
            self._wanted.set()      # wakes the thread
        if self._thread is None:
            return True
        self._thread.join(_SHUT_DOWN_S)
        return not self._thread.is_alive()

    def check(self) -> None:
        """Notice a source that is silent; to be called by the owner several times a second."""
        with self._lock:
            source, since = self._reading, self._reading_since
        if source is None or source.stall_timeout_s is None:
            return
        silent_s = self._now() - since
        if silent_s > source.stall_timeout_s:
            self._lose('{} has given no frame for {:.1f} s'.format(source.name, silent_s))

    def run(self) -> None:
        """Capture until shut down: what the thread does."""
        while True:
            self._wanted.wait()
            if self._ended:
                return
            self._closed.clear()
            try:
                self._capture()
            except Exception as error:      # whatever it is, the owner has to know
                self._request_stop()
                self._listener.failed(error, opening=False)
            finally:
                self._closed.set()

    def _request_stop(self) -> None:
        with self._lock:
            if not self._ended:
                self._wanted.clear()
            self._stopping.set()

    def _capture(self) -> None:
        retry_s = FIRST_RETRY_S
        while not self._stopping.is_set():
            try:
                source = self._open_source()
            except SourceError as error:
                if not self._known:
                    self._request_stop()
                    self._listener.failed(error, opening=True)
                    return
                self._lose(str(error))
            else:
                self._known = source.reconnects
                if self._play(source):
                    retry_s = FIRST_RETRY_S
            if self._pause(retry_s):
                return
            retry_s = min(2.0 * retry_s, LAST_RETRY_S)

    def _play(self, source: FrameSource) -> bool:
        """Pass on frames until there are no more; return whether there was any."""
        any_frame = False
        try:
            if not self._lost:
                self._listener.opened(source)
            pacer = Pacer(source.rate_hz, self._now) if source.rate_hz else None
            throttle = Throttle(source.max_hz) if source.max_hz else None
            while not self._stopping.is_set():
                image = self._read(source)
                if image is not None and throttle is not None and not throttle.accepts(
                        self._now() - source.age_s):
                    self._listener.dropped()
                    continue
                if pacer is not None and self._pause(pacer.delay_s()):
                    break
                if image is not None:
                    any_frame = True
                    self._find_again(source)
                    self._listener.frame(source, image)
        except SourceEnded as end:
            self._request_stop()
            self._listener.ended(str(end))
        except SourceError as error:
            if source.reconnects:
                self._lose(str(error))
            else:
                self._request_stop()
                self._listener.failed(error, opening=False)
        finally:
            # before it is opened again: a device that comes back while it is held gets a new name
            source.close()
        return any_frame

    def _read(self, source: FrameSource) -> Optional[np.ndarray]:
        """Return the next frame, None for one that cannot be used."""
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

    def _lose(self, reason: str) -> None:
        with self._lock:
            news = not self._lost and not self._stopping.is_set()
            self._lost = self._lost or news
        if news:
            self._listener.lost(reason)

    def _find_again(self, source: FrameSource) -> None:
        with self._lock:
            lost, self._lost = self._lost, False
        if lost:
            self._listener.opened(source)
            self._listener.reconnected()
