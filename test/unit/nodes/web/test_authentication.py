"""Who may use the page: requests to the ASGI middleware, one by one."""
import asyncio

import pytest

from img_recog.nodes.web import authentication
from img_recog.nodes.web.authentication import MAX_BODY_BYTES, Authentication

TOKEN, PORT = 'a-secret', 8080
COOKIE = 'img_recog_8080=' + TOKEN
OWN = 'http://localhost:8080'


class App:
    """Answers each request with ok, and each message on a WebSocket with the same text."""

    def __init__(self):
        self.visits, self.received, self.error = 0, [], None

    async def __call__(self, scope, receive, send):
        self.visits += 1
        while True:
            message = await receive()
            self.received.append(message)
            if self.error is not None:
                raise self.error
            if message['type'].endswith('.disconnect'):
                return
            if scope['type'] == 'http' and not message.get('more_body'):
                break
        await send({'type': 'http.response.start', 'status': 200, 'headers': []})
        await send({'type': 'http.response.body', 'body': b'ok'})


def visit(path='/', query='', messages=None, kind='http', method='GET', app=None, guard=None,
          **headers):
    """Return the application, what is sent to the visitor, and the reported errors."""
    app, sent, errors = app or App(), [], []
    guard = guard or Authentication(app, TOKEN, PORT, errors.append)
    scope = {'type': kind, 'path': path, 'query_string': query.encode(), 'method': method,
             'headers': [(name.replace('_', '-').encode(), value.encode())
                         for name, value in {'host': 'localhost:8080', **headers}.items()]}
    waiting = iter(messages if messages is not None else [
        {'type': 'http.request'} if kind == 'http' else {'type': 'websocket.connect'}])

    async def receive():
        return next(waiting, {'type': kind + '.disconnect'})

    async def send(message):
        sent.append(message)
    asyncio.run(guard(scope, receive, send))
    return app, sent, errors


def status(sent):
    return sent[0].get('status', sent[0]['type'])


@pytest.mark.parametrize('others', [
    'prefs={"a":1}', 'version=1', 'path=/x', 'flag', 'x=hello world', 'name=\u65e5', 'a[b]=1',
    'img_recog_8080=of-before', '=', ''])
def test_cookies_of_other_programs_keep_nobody_out(others):
    others = others.encode().decode('latin-1')
    for cookie in (others + '; ' + COOKIE, COOKIE + ';' + others):
        assert visit(cookie=cookie)[0].visits == 1
    assert visit(cookie=others)[0].visits == 0


def test_socket_io_is_served_by_web_sockets_only():
    """Messages of requests would not be limited."""
    app, sent, _ = visit('/_nicegui_ws/socket.io/', cookie=COOKIE, method='POST', origin=OWN)
    assert status(sent) == 400 and app.visits == 0
    app, _, _ = visit('/_nicegui_ws/socket.io/', kind='websocket', cookie=COOKIE, origin=OWN)
    assert app.visits == 1


def test_the_cookie_opens():
    app, sent, _ = visit(cookie=COOKIE)
    assert app.visits == 1 and status(sent) == 200


def test_the_token_becomes_a_cookie_that_scripts_and_other_sites_do_not_get():
    app, sent, _ = visit(query='token=' + TOKEN)
    assert app.visits == 0 and status(sent) == 200
    headers = dict(sent[0]['headers'])
    assert headers[b'cache-control'] == b'no-store'
    assert headers[b'set-cookie'] == (
        COOKIE + '; HttpOnly; Path=/; SameSite=strict').encode()
    assert TOKEN.encode() not in sent[1]['body']


@pytest.mark.parametrize('robot, page', [
    ('tb3_1', '/?robot=tb3_1'), ('lab/tb3_1', '/?robot=lab/tb3_1'), ('', '/'),
    ('%22%3E%3Cscript%3E', '/'), ('//evil.example', '/'), ('x' * 300, '/')])
def test_a_robot_in_the_address_is_kept(robot, page):
    _, sent, _ = visit(query='token={}&robot={}'.format(TOKEN, robot))
    assert 'url={}"'.format(page).encode() in sent[1]['body']


@pytest.mark.parametrize('visitor', [
    {}, {'query': 'token=wrong'}, {'query': 'token='}, {'query': 'token=' + TOKEN + 'x'},
    {'query': 'token=%ff%fe'}, {'query': 'token=' + TOKEN, 'path': '/graph.svg'},
    {'cookie': 'img_recog_8080=wrong'}, {'cookie': 'img_recog_9090=' + TOKEN},
    {'cookie': 'img_recog_8080="'}, {'cookie': '\x80'},
    {'cookie': COOKIE, 'origin': 'http://evil.example'}, {'cookie': COOKIE, 'origin': 'null'},
    {'cookie': COOKIE, 'origin': 'http://['},
    {'cookie': COOKIE, 'origin': 'http://localhost:9090', 'method': 'POST'},
    {'query': 'token=' + TOKEN, 'origin': 'http://evil.example'},
    {'cookie': COOKIE, 'sec_fetch_site': 'cross-site', 'sec_fetch_mode': 'no-cors'},
    {'cookie': COOKIE, 'sec_fetch_site': 'same-site', 'sec_fetch_mode': 'cors'},
    {'cookie': COOKIE, 'sec_fetch_site': 'cross-site', 'sec_fetch_mode': 'navigate',
     'method': 'POST'}])
def test_nothing_for_others(visitor):
    app, sent, _ = visit(**visitor)
    assert app.visits == 0 and status(sent) == 403
    assert b'address with the token' in sent[1]['body'] and TOKEN.encode() not in sent[1]['body']


@pytest.mark.parametrize('fetch', [
    {'sec_fetch_site': 'none', 'sec_fetch_mode': 'navigate'},
    {'sec_fetch_site': 'cross-site', 'sec_fetch_mode': 'navigate'},     # a link in another page
    {'sec_fetch_site': 'same-origin', 'sec_fetch_mode': 'cors', 'origin': OWN}])
def test_the_page_itself_may_be_opened_and_may_fetch(fetch):
    assert visit(cookie=COOKIE, **fetch)[0].visits == 1


@pytest.mark.parametrize('visitor, is_open', [
    ({'cookie': COOKIE, 'origin': OWN}, True), ({'origin': OWN}, False),
    ({'cookie': COOKIE}, False), ({'cookie': COOKIE, 'origin': 'http://evil.example'}, False),
    ({'query': 'token=' + TOKEN, 'origin': OWN}, False)])
def test_web_sockets_need_cookie_and_origin(visitor, is_open):
    app, sent, _ = visit('/live', kind='websocket', **visitor)
    assert app.visits == is_open
    assert is_open or [message['type'] for message in sent] == ['websocket.close']


def test_other_kinds_of_connections_pass():
    app, _, _ = visit(kind='lifespan')
    assert app.visits == 1


@pytest.mark.parametrize('length, code', [
    (str(MAX_BODY_BYTES), 200), (str(MAX_BODY_BYTES + 1), 413), ('-1', 413), ('many', 413)])
def test_large_requests_are_refused(length, code):
    assert status(visit(cookie=COOKIE, method='POST', content_length=length)[1]) == code


def test_a_request_that_is_larger_than_it_says_ends():
    parts = [{'type': 'http.request', 'body': bytes(MAX_BODY_BYTES // 2), 'more_body': True}] * 3
    app, sent, _ = visit(cookie=COOKIE, method='POST', messages=parts)
    assert app.received[-1] == {'type': 'http.disconnect'} and sent == []


def test_thousands_of_messages_end_a_web_socket(monkeypatch):
    monkeypatch.setattr(authentication, '_MESSAGES_BURST', 2.0)
    monkeypatch.setattr(authentication, '_MESSAGES_HZ', 0.0)
    messages = [{'type': 'websocket.connect'}] + [
        {'type': 'websocket.receive', 'text': text} for text in 'abcd']
    app, _, _ = visit('/live', kind='websocket', cookie=COOKIE, origin=OWN, messages=messages)
    assert [message.get('text') for message in app.received] == [None, 'a', 'b', None]
    assert app.received[-1]['code'] == 1008


def test_too_many_connections(monkeypatch):
    monkeypatch.setattr(authentication, 'MAX_CONNECTIONS', 1)
    codes = []

    async def visited_meanwhile(scope, receive, send):
        async def send_code(message):
            codes.append(message.get('status'))
        await guard(scope, receive, send_code)
    guard = Authentication(visited_meanwhile, TOKEN, PORT, lambda _: None)
    for _ in range(2):          # the first one has ended
        visit(cookie=COOKIE, guard=guard)
    assert codes == [503, None, 503, None]


@pytest.mark.parametrize('messages, is_reported', [(None, True), ([], False)])
def test_an_error_of_the_application_is_reported_unless_the_visitor_is_gone(messages,
                                                                            is_reported):
    app = App()
    app.error = ValueError('a mistake')
    errors = visit(cookie=COOKIE, messages=messages, app=app)[2]
    assert errors == ([app.error] if is_reported else [])
