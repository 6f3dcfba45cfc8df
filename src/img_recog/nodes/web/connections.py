"""The connections to the page: time limits, and the limit for those without the token."""
import asyncio
from typing import Any, Dict, List, Optional

from starlette.types import Scope
from uvicorn.protocols.http.h11_impl import H11Protocol

HEADER_TIMEOUT_S = 10.0     # from the start of the connection, or from the last response
MAX_STRANGERS = 200         # connections that have not shown the token
# uvicorn accepts so many connections at a time and reads from them afterward: a visitor's header
# is read before MAX_STRANGERS newer connections push this connection out
ACCEPTED_AT_A_TIME = 50
_ADMIT = 'admit'            # the key in the state of a request


def admit(scope: Scope) -> None:
    """Exempt the connection of a request, which has the token, from the limit of strangers."""
    if _ADMIT in scope.get('state', {}):
        scope['state'][_ADMIT]()


class Connection(H11Protocol):
    """A connection of uvicorn that ends if the next header takes too long.

    It is a stranger until a request on it has the token. If there are too many strangers, the
    oldest one makes room for the newest one.
    """

    def __init__(self, *arguments: Any, **named: Any):
        """Take the arguments of H11Protocol."""
        super().__init__(*arguments, **named)
        self._is_stranger, self._began_s = True, self.loop.time()
        self._deadline: Optional[asyncio.TimerHandle] = None
        self.app_state: Dict[str, Any] = {**self.app_state, _ADMIT: self._admit}

    def connection_made(self, transport: Any) -> None:
        """Start to wait for a header; end the oldest stranger if there are too many."""
        super().connection_made(transport)
        self._wait_for_header()
        strangers: List[Connection] = [
            each for each in self.connections if isinstance(each, Connection)
            and each._is_stranger and not each.transport.is_closing()]
        if len(strangers) > MAX_STRANGERS:
            min(strangers, key=lambda each: each._began_s).transport.abort()

    def connection_lost(self, exc: Optional[Exception]) -> None:
        """Note the end of the connection."""
        self._stop_waiting()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Stop to wait for a header if it is complete."""
        cycle = self.cycle
        super().handle_events()
        if self.cycle is not cycle:
            self._stop_waiting()

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Leave the connection to another protocol, which has a time limit for its handshake."""
        self._stop_waiting()
        super().handle_websocket_upgrade(event)

    def on_response_complete(self) -> None:
        """Start to wait for the next header."""
        self._wait_for_header()
        super().on_response_complete()

    def _wait_for_header(self) -> None:
        self._stop_waiting()
        self._deadline = self.loop.call_later(HEADER_TIMEOUT_S, self._end)

    def _stop_waiting(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()

    def _admit(self) -> None:
        self._is_stranger = False

    def _end(self) -> None:
        # close() would wait until a stranger has read everything
        (self.transport.abort if self._is_stranger else self.transport.close)()
