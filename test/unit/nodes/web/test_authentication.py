"""Who may use the page: requests to the ASGI middleware, one by one."""
import asyncio

import pytest

from img_recog.nodes.web.authentication import Authentication

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
    guard = guard or Authentication(app, TOKEN, PORT, errors.append, lambda: None)
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


@pytest.mark.parametrize('visitor, count', [
    ({}, 1), ({'query': 'token=of-the-demo-before'}, 1), ({'cookie': 'img_recog_8080=x'}, 1),
    ({'query': 'token=' + TOKEN}, 0), ({'cookie': COOKIE}, 0), ({'path': '/graph.svg'}, 0),
    ({'kind': 'websocket', 'origin': OWN}, 0), ({'origin': 'http://evil.example'}, 0)])
def test_who_opens_the_page_without_the_token_is_reminded_of_it(visitor, count):
    reminders, app = [], App()
    visit(app=app, guard=Authentication(app, TOKEN, PORT, print, lambda: reminders.append(1)),
          **visitor)
    assert len(reminders) == count


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


@pytest.mark.parametrize('messages, is_reported', [(None, True), ([], False)])
def test_an_error_of_the_application_is_reported_unless_the_visitor_is_gone(messages,
                                                                            is_reported):
    app = App()
    app.error = ValueError('a mistake')
    errors = visit(cookie=COOKIE, messages=messages, app=app)[2]
    assert errors == ([app.error] if is_reported else [])
