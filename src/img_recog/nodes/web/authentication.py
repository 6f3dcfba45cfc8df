"""Who may use the page: a token, same-origin requests, and limits. Independent of ROS.

Works as ASGI middleware in front of everything that the node serves.
"""
import hmac
import re
import time
import urllib.parse
from typing import Callable, List, Optional

from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from img_recog.nodes.web.token_bucket import TokenBucket

MAX_BODY_BYTES = 1 << 16        # of a request; also of a message on a WebSocket
MAX_CONNECTIONS = 200
_MESSAGES_BURST, _MESSAGES_HZ = 400.0, 200.0    # of one WebSocket
_TOO_MANY = 1008                # a close code of RFC 6455
_SAFE_METHODS = ('GET', 'HEAD')
# of NiceGUI's socket.io, which could also poll by requests, where messages are not limited
_SOCKETS = '/_nicegui_ws/'

# Sent with the cookie, in place of a redirect: a browser that comes from a link in another site
# would not send a SameSite=Strict cookie with a redirected request.
_ENTER = ('<!doctype html><html lang="en"><meta charset="utf-8"><title>img_recog</title>'
          '<meta http-equiv="refresh" content="0;url={0}"><a href="{0}">img_recog</a></html>')
_ROBOT = re.compile('[A-Za-z][A-Za-z0-9_/]{0,255}')
_REFUSALS = {
    400: 'Only WebSockets are served here.\n',
    403: 'This page needs the address with the token that the terminal shows after it has '
         'started: http://.../?token=...\n',
    413: 'The request is too large.\n',
    503: 'Too many connections: close other pages.\n'}


class Authentication:
    """Lets requests to an ASGI application pass only with the token.

    A request with ?token=... gets the token as a cookie. All others need this cookie, and must
    not come from a page of another origin.
    """

    def __init__(self, app: ASGIApp, token: str, port: int,
                 failed: Callable[[Exception], None]):
        """Guard `app`.

        port: of the page, as browsers share cookies between ports. failed: is called with an
        error of `app`, unless the visitor was gone by then.
        """
        self._app, self._token, self._cookie = app, token, 'img_recog_{}'.format(port)
        self._failed = failed
        self._connections = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a connection."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        answer = self._answer(HTTPConnection(scope))
        if answer is not None:
            await answer(scope, receive, send)
            return
        self._connections += 1
        visit = _Visit(scope, receive)
        try:
            await self._app(scope, visit.receive, send)
        except Exception as error:
            if not visit.has_ended:
                self._failed(error)
        finally:
            self._connections -= 1

    def _answer(self, request: HTTPConnection) -> Optional[ASGIApp]:
        """Return what is answered in place of the application, None for who may pass."""
        status = self._status(request)
        if status == 200:
            return self._entrance(request.query_params.get('robot', ''))
        if status is None:
            return None
        if request.scope['type'] == 'websocket':    # closing before it is accepted answers 403
            return WebSocketClose(_TOO_MANY)
        return PlainTextResponse(_REFUSALS[status], status)

    def _entrance(self, robot: str) -> HTMLResponse:
        """Return the page that sets the cookie and leads to that of a robot."""
        page = '/?robot=' + robot if _ROBOT.fullmatch(robot) else '/'
        response = HTMLResponse(_ENTER.format(page), headers={'cache-control': 'no-store'})
        response.set_cookie(self._cookie, self._token, httponly=True, samesite='strict')
        return response

    def _status(self, request: HTTPConnection) -> Optional[int]:
        """Return the HTTP status of a refusal, 200 for a visitor with the token, None if allowed.
        """
        if _is_foreign(request):
            return 403
        is_http, path = request.scope['type'] == 'http', request.scope['path']
        if is_http and path == '/' and 'token' in request.query_params:
            return 200 if self._is_token(request.query_params['token']) else 403
        cookies = _cookies(request.headers.get('cookie', ''), self._cookie)
        if not any(map(self._is_token, cookies)):
            return 403
        if is_http and path.startswith(_SOCKETS):
            return 400
        length = request.headers.get('content-length', '0')
        if not length.isdecimal() or int(length) > MAX_BODY_BYTES:
            return 413
        return 503 if self._connections >= MAX_CONNECTIONS else None

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self._token.encode())


def _is_foreign(request: HTTPConnection) -> bool:
    """Return whether the request comes from a page of another origin.

    Browsers send Origin with each WebSocket and each request that can change something, and
    Sec-Fetch-Site with all others; links in other pages may open the page itself.
    """
    headers, origin = request.headers, request.headers.get('origin')
    if origin is not None and _host(origin) != headers.get('host'):
        return True
    if headers.get('sec-fetch-site') in ('cross-site', 'same-site'):
        return (headers.get('sec-fetch-mode') != 'navigate'
                or request.scope.get('method') not in _SAFE_METHODS)
    return request.scope['type'] == 'websocket' and origin is None


def _host(origin: str) -> Optional[str]:
    try:
        return urllib.parse.urlsplit(origin).netloc
    except ValueError:      # like http://[
        return None


def _cookies(text: str, name: str) -> List[str]:
    """Return the values of the cookies of this name.

    Other programs on this computer may have set cookies of any form: http.cookies drops all after
    the first one that it does not understand, and Starlette's keep the last one of a name.
    """
    pairs = (part.strip().partition('=') for part in text.split(';'))
    return [value for key, _, value in pairs if key == name]


class _Visit:
    """What comes in over a connection, until it ends or too much is sent.

    A message of a WebSocket that is too large ends it before, in uvicorn. has_ended: whether the
    visitor has left.
    """

    def __init__(self, scope: Scope, receive: Receive):
        self._receive, self._is_http = receive, scope['type'] == 'http'
        self._body_bytes = 0
        self._messages = TokenBucket(_MESSAGES_BURST, _MESSAGES_HZ)
        self.has_ended = False

    async def receive(self) -> Message:
        """Return the next message, for the application."""
        begin_s = time.monotonic()
        message = await self._receive()
        # not the time between: what has come while the application was busy came at once
        waited_s = time.monotonic() - begin_s
        if self._is_http:
            self._body_bytes += len(message.get('body', b''))
            if self._body_bytes > MAX_BODY_BYTES:
                message = {'type': 'http.disconnect'}
        elif message['type'] == 'websocket.receive' and not self._messages.take(1, waited_s):
            message = {'type': 'websocket.disconnect', 'code': _TOO_MANY}
        self.has_ended = self.has_ended or message['type'].endswith('.disconnect')
        return message
