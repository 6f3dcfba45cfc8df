"""Limits for what a connection of the page sends, before it is parsed, and leaves unread."""
import asyncio
from typing import Any, Optional

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.auto import AutoWebSocketsProtocol

from img_recog.nodes.web.authentication import MAX_BODY_BYTES
from img_recog.nodes.web.token_bucket import TokenBucket

_MAX_REQUEST_BYTES = 2 * MAX_BODY_BYTES     # header, body and trailer
_TIME_LIMIT_S = 10.
_READ_BYTES = 4096
# of one WebSocket; pings and parts of messages count, which Authentication does not see
_BURST_BYTES, _BYTES_HZ = 4.0 * MAX_BODY_BYTES, 1.0 * MAX_BODY_BYTES


class _Reading:
    """Mixin for a protocol: closes a connection whose other end has stopped reading."""

    transport: asyncio.Transport
    loop: asyncio.AbstractEventLoop
    _unread: Optional[asyncio.TimerHandle] = None

    def connection_lost(self, exc) -> None:
        """Forget the time limit."""
        self._stop_watching()
        super().connection_lost(exc)        # type: ignore[misc]

    def pause_writing(self) -> None:
        """Watch whether the other end reads any of what waits for it."""
        super().pause_writing()             # type: ignore[misc]
        self._watch()

    def resume_writing(self) -> None:
        """End the watch."""
        self._stop_watching()
        super().resume_writing()            # type: ignore[misc]

    def _watch(self, before: float = float('inf')) -> None:
        waiting = self.transport.get_write_buffer_size()
        if waiting >= before:
            self.transport.abort()
        else:
            self._unread = self.loop.call_later(_TIME_LIMIT_S, self._watch, waiting)

    def _stop_watching(self) -> None:
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None


class LimitedHttp(_Reading, HttpToolsProtocol):
    """HTTP of uvicorn that closes a connection whose request is too long or too slow.

    httptools joins the pieces of a header without a limit: memory grows, and each piece copies
    all before it. The request that opens a WebSocket passes here too.
    """

    _timer: Optional[asyncio.TimerHandle] = None
    _received = 0       # bytes of the present request

    def connection_made(self, transport) -> None:
        """Start the time limit: a connection may send nothing at all."""
        super().connection_made(transport)
        # What has been read is parsed and queued in one go: a flood of small frames, of which
        # asyncio reads 256 kB, would keep others waiting, and fill the memory in spite of
        # pause_reading. A WebSocket keeps the transport.
        transport.max_size = _READ_BYTES
        self._start()

    def connection_lost(self, exc) -> None:
        """Forget the time limit."""
        self._stop()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse data, unless the request has been too long before it."""
        if self._received > _MAX_REQUEST_BYTES:
            self.transport.abort()
            return
        self._received += len(data)
        self._start()
        super().data_received(data)

    def on_message_begin(self) -> None:
        """Start the time limit of a request that follows another one in the same data."""
        self._start()
        super().on_message_begin()

    def on_message_complete(self) -> None:
        """End the limits of this request."""
        self._stop()
        super().on_message_complete()

    def _start(self) -> None:
        if self._timer is None:
            self._timer = self.loop.call_later(_TIME_LIMIT_S, self.transport.abort)

    def _stop(self) -> None:
        self._received = 0
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class LimitedWebSocket(_Reading, AutoWebSocketsProtocol):   # type: ignore[misc, valid-type]
    """WebSocket of uvicorn that closes a connection which sends too much."""

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._bytes = TokenBucket(_BURST_BYTES, _BYTES_HZ)
        self._time_s = self.loop.time()

    def data_received(self, data: bytes) -> None:
        """Parse data, unless it is too much."""
        before_s, self._time_s = self._time_s, self.loop.time()
        if self._bytes.take(len(data), self._time_s - before_s):
            super().data_received(data)
        else:
            self.transport.abort()
