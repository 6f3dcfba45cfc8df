"""A master or node of a test, by real XML-RPC on the loopback."""
import threading
from socketserver import ThreadingMixIn
from xmlrpc.server import SimpleXMLRPCServer


class XmlRpcServer(ThreadingMixIn, SimpleXMLRPCServer):
    """Answers with the methods that it is given, until it is stopped."""

    daemon_threads, block_on_close = True, False

    def __init__(self, port=0, dispatch=None, **methods):
        """dispatch: called with the name of any method that is not given, and its arguments."""
        super().__init__(('127.0.0.1', port), logRequests=False)
        for name, method in methods.items():
            self.register_function(method, name)
        self.register_multicall_functions()
        self._other, self.port = dispatch, self.server_address[1]
        self.uri = 'http://127.0.0.1:{}/'.format(self.port)
        threading.Thread(target=self.serve_forever, args=(0.01,), daemon=True).start()

    def _dispatch(self, method, params):
        if method in self.funcs or self._other is None:
            return super()._dispatch(method, params)
        return self._other(method, *params)

    def handle_error(self, *_):
        """Print nothing: a caller may have left."""

    def stop(self):
        """Refuse connections from now on."""
        self.shutdown()
        self.server_close()
