"""Hostile connections to the page of a running demo."""
import contextlib
import itertools
import random
import resource
import socket
import time
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import Callable, Dict, Iterator, Mapping, Tuple

from img_recog_helpers import process_table
from img_recog_helpers.process_table import Usage
from img_recog_helpers.reliability import demo as demos
from img_recog_helpers.reliability.demo import LIMIT_S, START_LIMIT_S, Demo
from img_recog_helpers.waiting import DEADLINE_S, wait_for

Address = Tuple[str, int]
# what a connection sends, piece by piece; it takes time where it is slow
Pieces = Callable[[random.Random], Iterator[bytes]]

_AT_ONCE = 12
_ATTACK_S = 8.0             # of one connection that is not closed
_DESCRIPTORS = 64           # as after ulimit -n 64
_EXTRA = {'threads': 8, 'descriptors': 8}
_MAX_GROWTH_MB = 100.0
_SETTLE_S = 90.0
_BLOCK = b'x' * 65536


def _nothing(rng: random.Random) -> Iterator[bytes]:
    yield b''


def _bytes(rng: random.Random) -> Iterator[bytes]:
    yield bytes(rng.randrange(256) for _ in range(rng.randrange(4096)))


def _then(start: bytes, *rest: bytes, slow: bool = False) -> Pieces:
    """Send a start, then the rest again and again."""
    def pieces(rng: random.Random) -> Iterator[bytes]:
        yield start
        for piece in itertools.cycle(rest):
            if slow:
                time.sleep(rng.uniform(0.0, 0.2))
            yield piece
    return pieces


_UPGRADE = (b'GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nHost: x\r\n'
            b'Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n')
_ANYWHERE: Dict[str, Pieces] = {
    'silent': _nothing, 'bytes': _bytes,
    'slow header': _then(b'POST / HTTP/1.1\r\n', b'a: b\r\n', slow=True),
    'slow value': _then(b'POST / HTTP/1.1\r\na: ', b'x', slow=True),
    'endless header': _then(b'POST / HTTP/1.1\r\n', b'a: b\r\n' * 10000),
    'endless value': _then(b'GET / HTTP/1.1\r\na: ', _BLOCK),
    'endless path': _then(b'GET /', _BLOCK),
    'slow body': _then(b'POST / HTTP/1.1\r\nContent-Length: 100000\r\n\r\n', b'<', slow=True),
    'endless body': _then(b'POST / HTTP/1.1\r\nContent-Length: 999999999999\r\n\r\n', _BLOCK),
    'endless chunks': _then(b'POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n',
                            b'10000\r\n' + _BLOCK + b'\r\n')}


def _of_page(token: bytes, cookie: bytes) -> Dict[str, Pieces]:
    """Return what is sent to the page, without its token and with it."""
    pair = b'\r\nCookie: ' + cookie + b'=' + token + b'\r\n\r\n'
    with_token = (_UPGRADE + b'Origin: http://x\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA=='
                  + pair)
    whole = b'GET / HTTP/1.1\r\nHost: x' + pair
    return {
        **_ANYWHERE,
        'slow upgrade': _then(_UPGRADE, b'a: b\r\n', slow=True),
        'endless upgrade': _then(_UPGRADE, b'a: b\r\n' * 10000),
        'endless value of an upgrade': _then(_UPGRADE + b'a: ', _BLOCK),
        'silent WebSocket': _then(with_token, b'', slow=True),
        'endless frame': _then(with_token + b'\x82\xff\x7f' + b'\xff' * 7 + bytes(4), _BLOCK),
        'fragments': _then(with_token + b'\x02\xfe\x10\x00' + bytes(4 + 4096),
                           b'\x00\xfe\x10\x00' + bytes(4 + 4096)),
        'pages': _then(whole, whole, slow=True)}


def _attack(address: Address, pieces: Iterator[bytes], duration_s: float) -> None:
    """Send until the other end closes the connection or the time is over."""
    end = time.monotonic() + duration_s
    with contextlib.suppress(OSError), socket.create_connection(address, DEADLINE_S) as sock:
        sock.settimeout(0.5)
        for piece in pieces:
            sent = 0
            while sent < len(piece):
                if time.monotonic() > end:
                    return
                with contextlib.suppress(socket.timeout):
                    sent += sock.send(piece[sent:])
            if time.monotonic() > end:
                return
        while time.monotonic() < end:
            with contextlib.suppress(socket.timeout):
                if not sock.recv(65536):
                    return


def _sustain(demo: Demo, rng: random.Random, target: Address, kinds: Mapping[str, Pieces],
             how: Tuple[float, float], check: Callable[[], float]) -> Tuple[int, float]:
    """Attack at random for a time; return the number of attacks and the slowest answer.

    how: the time in s, and the factor of all limits. check: returns how long an answer took for a
    user meanwhile.
    """
    duration_s, factor = how
    end, slowest_s = time.monotonic() + duration_s, 0.0
    count = itertools.count()

    def attack_all(number: int) -> None:
        own = random.Random(number)
        while time.monotonic() < end:
            kind = own.choice(list(kinds))
            _attack(target, kinds[kind](own), own.uniform(0, _ATTACK_S))
            next(count)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        running = [pool.submit(attack_all, rng.randrange(1 << 32)) for _ in range(_AT_ONCE)]
        while time.monotonic() < end:
            slowest_s = max(slowest_s, check(), demo.chain.wait(LIMIT_S * factor).recovered_s)
        for each in running:
            each.result()
    return next(count), slowest_s


def _exhaust(demo: Demo, target: Address, factor: float) -> None:
    """Let connections use all descriptors of the page; it has to work when they are gone."""
    pid = demo.pid('web')
    few = max(_DESCRIPTORS, process_table.usage(pid).descriptors + 8)
    soft, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (few, hard))
    with contextlib.ExitStack() as stack:
        for _ in range(2 * few):
            with contextlib.suppress(OSError):
                stack.enter_context(socket.create_connection(target, 0.2))
        wait_for(lambda: process_table.usage(pid).descriptors >= few - 4,
                 'the limit of the descriptors of the page')
        time.sleep(1.0)
    demo.chain.wait(LIMIT_S * factor)
    assert demo.pid('web') == pid, demo.launch.output[-3000:]
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (soft, hard))


def page(duration_s: float, seed: int, factor: float = 1.0) -> Dict[str, float]:
    """Attack the page while the chain works and the page answers others; returns figures.

    These are the number of attacks, the slowest answer, and the growth of memory.
    """
    with Demo() as demo:
        demo.start_all('web:=true', 'web_port:=18080')
        address, port, token = demo.launch.wait_output(
            r'the page: (http://localhost:(\d+)/)\?token=(\S+)').groups()
        demo.chain.wait(START_LIMIT_S * factor)
        target = ('localhost', int(port))
        kinds = _of_page(token.encode(), b'img_recog_' + port.encode())

        def usage() -> Dict[str, Usage]:
            return {**demo.usage(), 'web': process_table.usage(demo.pid('web'))}

        def answered() -> float:
            begin = time.monotonic()
            with socket.create_connection(target, LIMIT_S * factor) as sock:
                sock.sendall(b'GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n')
                assert sock.recv(100).startswith(b'HTTP/1.1 403'), address
            return time.monotonic() - begin
        # the first pages start threads and publishers that stay
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            list(pool.map(_open_page, [(address, port, token)] * _AT_ONCE))
        before = usage()
        count, slowest_s = _sustain(demo, random.Random(seed), target, kinds,
                                    (duration_s, factor), answered)
        _exhaust(demo, target, factor)
        result = _growth(demo, before, usage, factor)
        demo.stop(demos.STOP_LIMIT_S * factor)
        return {'attacks': count, 'max_s': slowest_s, **result}


def _open_page(place: Tuple[str, str, str]) -> None:
    """Get the page as a browser does. place: its address, port and token."""
    address, port, token = place
    request = urllib.request.Request(
        address, headers={'Cookie': 'img_recog_{}={}'.format(port, token)})
    with urllib.request.urlopen(request, timeout=DEADLINE_S) as answer:
        assert answer.status == HTTPStatus.OK


def _growth(demo: Demo, before: Dict[str, Usage], usage: Callable[[], Dict[str, Usage]],
            factor: float) -> Dict[str, float]:
    """Return by how many MB the nodes have grown, once nothing else is left of the attacks."""
    wait_for(lambda: not demos.problems(before, usage(), _EXTRA),
             lambda: demos.problems(before, usage(), _EXTRA), _SETTLE_S * factor)
    after = usage()
    assert {name: used.pid for name, used in before.items()} == {
        name: used.pid for name, used in after.items()}, demo.launch.output[-3000:]
    assert not demos.problems(before, after, {'rss_mb': _MAX_GROWTH_MB}), after
    assert 'Traceback' not in demo.launch.output, demo.launch.output[-3000:]
    return {'MB of {} (start {:.0f})'.format(name, used.rss_mb): round(
        after[name].rss_mb - used.rss_mb) for name, used in before.items()}
