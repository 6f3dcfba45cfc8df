"""Who may use the page: a token, and same-origin requests. Independent of ROS.

Works as ASGI middleware in front of everything that the node serves.
"""
import hmac
import re
import urllib.parse
from typing import Callable, List, Optional

from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from img_recog.nodes.web.connections import admit

_REFUSED = 1008                 # a close code of RFC 6455
_SAFE_METHODS = ('GET', 'HEAD')

# Sent with the cookie, in place of a redirect: a browser that comes from a link in another site
# would not send a SameSite=Strict cookie with a redirected request.
_ENTER = ('<!doctype html><html lang="en"><meta charset="utf-8"><title>img_recog</title>'
          '<meta http-equiv="refresh" content="0;url={0}"><a href="{0}">img_recog</a></html>')
_ROBOT = re.compile('[A-Za-z][A-Za-z0-9_/]{0,255}')
_REFUSAL = ('This page needs the address with the token. The terminal of the demo shows it now: '
            'http://.../?token=...\n')


class Authentication:
    """Lets requests to an ASGI application pass only with the token.

    A request with ?token=... gets the token as a cookie. All others need this cookie, and must
    not come from a page of another origin.
    """

    def __init__(self, app: ASGIApp, token: str, port: int,
                 failed: Callable[[Exception], None], remind: Callable[[], None]):
        """Guard `app`.

        Args:
            app: Application that is guarded.
            token: Token that a visitor needs.
            port: Port of the page, as browsers share cookies between ports.
            failed: Called with an error of `app`, unless the visitor was gone by then.
            remind: Called if a visitor opens the page without the token.
        """
        self._app, self._token, self._cookie = app, token, 'img_recog_{}'.format(port)
        self._failed, self._remind = failed, remind

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a connection."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        answer = self._answer(HTTPConnection(scope))
        if answer is not None:
            await answer(scope, receive, send)
            return
        has_ended = False           # the visitor has left

        async def receive_noting() -> Message:
            nonlocal has_ended
            message = await receive()
            has_ended = has_ended or message['type'].endswith('.disconnect')
            return message
        try:
            await self._app(scope, receive_noting, send)
        except Exception as error:
            if not has_ended:
                self._failed(error)

    def _answer(self, request: HTTPConnection) -> Optional[ASGIApp]:
        """Return what is answered in place of the application, None for who may pass."""
        is_http, query = request.scope['type'] == 'http', request.query_params
        if not _is_foreign(request):
            is_page = is_http and request.scope['path'] == '/'
            if is_page and 'token' in query:
                if self._is_token(query['token']):
                    admit(request.scope)
                    return self._entrance(query.get('robot', ''))
            elif any(map(self._is_token, _cookies(
                    request.headers.get('cookie', ''), self._cookie))):
                admit(request.scope)
                return None
            if is_page:
                self._remind()
        # closing a WebSocket before it is accepted answers 403
        return PlainTextResponse(_REFUSAL, 403) if is_http else WebSocketClose(_REFUSED)

    def _entrance(self, robot: str) -> HTMLResponse:
        """Return the page that sets the cookie and leads to that of a robot."""
        page = '/?robot=' + robot if _ROBOT.fullmatch(robot) else '/'
        response = HTMLResponse(_ENTER.format(page), headers={'cache-control': 'no-store'})
        response.set_cookie(self._cookie, self._token, httponly=True, samesite='strict')
        return response

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
