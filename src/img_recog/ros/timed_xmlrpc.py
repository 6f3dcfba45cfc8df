"""XML-RPC calls with a time limit: a node that is stopped takes connections, never answers."""
import http.client
import xmlrpc.client
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Dict, Iterable, List, Mapping, NamedTuple, Set, Tuple

# everything that a call raises when there is no usable answer
ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error)
THREADS = 8             # that ask nodes at the same time


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


class SystemState(NamedTuple):
    """The nodes of each topic that is published or subscribed to, and of each service."""

    published: Dict[str, List[str]]
    subscribed: Dict[str, List[str]]
    services: Dict[str, List[str]]

    @property
    def nodes(self) -> Set[str]:
        """All of them."""
        return {node for kind in self for nodes in kind.values() for node in nodes}


class Master:
    """The calls of one node. proxy: for those whose whole answer matters.

    Those that get no answer raise one of ERRORS.
    """

    def __init__(self, uri: str, node: str, timeout_s: float):
        self.proxy, self._node, self._timeout_s = server(uri, timeout_s), node, timeout_s

    def __enter__(self) -> 'Master':
        return self

    def __exit__(self, *_: object) -> None:
        self.proxy('close')()

    def call(self, method: str, *arguments: Any) -> Any:
        """Return the value; raise xmlrpc.client.Error if the master refuses the call."""
        code, message, value = getattr(self.proxy, method)(self._node, *arguments)
        if code != 1:
            raise xmlrpc.client.Error('{}: {}'.format(method, message))
        return value

    def ask(self, method: str, *arguments: Any) -> Any:
        """Return the value, None if there is none or XML-RPC cannot transmit it.

        Raises OSError if the master does not answer.
        """
        try:
            return self.call(method, *arguments)
        except OSError:
            raise
        except http.client.HTTPException as error:
            raise OSError(str(error))
        except Exception:       # an integer of more than 32 bits, for example
            return None

    def state(self) -> SystemState:
        """Return who uses what. Raises OSError if the master does not say that."""
        try:
            return SystemState(*(dict(kind) for kind in self.call('getSystemState')))
        except (*ERRORS[1:], TypeError, ValueError) as error:
            raise OSError(str(error))

    def ask_nodes(self, nodes: Iterable[str], question: Callable[[str, Any], Any]
                  ) -> Dict[str, Tuple[str, Any]]:
        """Return the address of each node, and its answer, or the exception that there is none.

        question: gets a node's name and its proxy, in one of several threads. Raises OSError if
        the master does not answer.
        """
        lookups, uris = xmlrpc.client.MultiCall(self.proxy), dict.fromkeys(sorted(nodes), '')
        for node in uris:
            lookups.lookupNode(self._node, node)
        try:
            answers: Any = lookups()
            for node, (code, _, uri) in zip(list(uris), answers):
                uris[node] = str(uri) if code == 1 else ''
        except (*ERRORS[1:], TypeError, ValueError) as error:
            raise OSError(str(error))

        def answer(node: str) -> Any:
            try:
                with server(uris[node], self._timeout_s) as proxy:
                    return question(node, proxy)
            except (*ERRORS, ValueError, TypeError, IndexError) as error:
                return error
        with ThreadPoolExecutor(THREADS) as pool:
            return {node: (uris[node], each) for node, each in zip(uris, pool.map(answer, uris))}

    def shared_parameters(self) -> Dict[str, Any]:
        """Return the parameters of others that nodes read, as far as there are any."""
        names = filter(None, ('/use_sim_time', self.ask('searchParam', 'robot_description')))
        values = {name: self.ask('getParam', name) for name in names}
        return {name: value for name, value in values.items() if value is not None}

    def set_missing(self, values: Mapping[str, Any]) -> int:
        """Set the parameters that the master does not have; return their number."""
        missing = [name for name in values if self.ask('hasParam', name) is False]
        return sum(self.ask('setParam', name, values[name]) is not None for name in missing)
