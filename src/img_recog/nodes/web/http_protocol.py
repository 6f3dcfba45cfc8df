"""Limits for what a connection of the page sends, before it is parsed: size and time."""
import asyncio
from typing import Optional

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from img_recog.nodes.web.authentication import MAX_BODY_BYTES

_MAX_REQUEST_BYTES = 2 * MAX_BODY_BYTES     # header, body and trailer
_TIME_LIMIT_S = 10.


class LimitedHttp(HttpToolsProtocol):
    """HTTP of uvicorn that closes a connection whose request is too long or too slow.

    httptools joins the pieces of a header without a limit: memory grows, and each piece copies
    all before it. The request that opens a WebSocket passes here too.
    """

    _timer: Optional[asyncio.TimerHandle] = None
    _received = 0       # bytes of the present request

    def connection_made(self, transport) -> None:
        """Start the time limit: a connection may send nothing at all."""
        super().connection_made(transport)
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
