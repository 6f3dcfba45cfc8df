"""XML-RPC calls with a time limit: a node that is stopped takes connections, never answers."""
import http.client
import xmlrpc.client
from typing import Any

# everything that a call raises when there is no usable answer
ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error)


class _Transport(xmlrpc.client.Transport):
    def __init__(self, timeout_s: float):
        super().__init__()
        self._timeout_s = timeout_s

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout_s
        return connection

    def parse_response(self, response: Any) -> Any:
        try:
            return super().parse_response(response)
        except ERRORS:
            raise
        except Exception as error:      # no XML, or values that make no sense
            raise xmlrpc.client.ResponseError('no XML-RPC: {}'.format(error))


def server(uri: str, timeout_s: float = 1.0) -> xmlrpc.client.ServerProxy:
    """Return a proxy of a master or node, whose calls raise one of ERRORS.

    Raises OSError if the address is of another protocol than HTTP.
    """
    return xmlrpc.client.ServerProxy(uri, _Transport(timeout_s), allow_none=True)
