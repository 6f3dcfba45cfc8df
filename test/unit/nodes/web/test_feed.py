"""What pages get and send over their WebSocket, with plain objects in place of ROS."""
import asyncio
import json
import time
from typing import NamedTuple

import pytest

from img_recog.nodes.web import feed
from img_recog.nodes.web.feed import Feed, Picture
from img_recog.nodes.web.news import News
from img_recog_testing.waiting import DEADLINE_S, stretch

CAMERA, BLUE = '/usb_cam/image_raw', '/blue_image'


def decoded(data):
    """Return the JSON text, decoded, and the pictures of a message, like the page does."""
    length = int.from_bytes(data[:4], 'big')
    start = 4 + length
    news, jpegs = json.loads(data[4:start]), []
    for _, size in news['pictures']:
        jpegs.append(data[start:start + size])
        start += size
    return news, jpegs


class Pictures:
    def __init__(self):
        self.watched, self.pictures = set(), {}

    def watch(self, names):
        self.watched = names

    def latest(self, name):
        return self.pictures.get(name)


class Measurements(News):
    is_watched = False

    def watch(self, is_watched):
        self.is_watched = is_watched


class Driver:
    def __init__(self):
        self.calls = []

    is_free = True

    def hold(self, owner, linear, angular):
        self.calls.append((linear, angular))
        return self.is_free

    def release(self, owner):
        self.calls.append(None)


class Robot(NamedTuple):
    measurements: Measurements
    driving: Driver


class Gone(Exception):
    """The connection has ended."""


class Socket:
    """A browser: sends the texts of a queue; `reads` is cleared while it does not read."""

    def __init__(self):
        self.texts, self.received, self.code = asyncio.Queue(), [], None
        self.reads = asyncio.Event()
        self.reads.set()

    def send(self, **message):
        self.texts.put_nowait(json.dumps(message))

    async def receive_text(self):
        text = await self.texts.get()
        if text is None:
            raise Gone
        if isinstance(text, bytes):
            raise KeyError('text')      # like Starlette
        return text

    async def send_bytes(self, data):
        await self.reads.wait()
        self.received.append(decoded(data))

    async def close(self, code=1000):
        self.code = code


async def until(condition):
    """Wait for a condition while the feed runs."""
    begin_s = time.monotonic()
    while not condition():
        assert time.monotonic() < begin_s + DEADLINE_S * stretch()
        await asyncio.sleep(1 / feed.RATE_HZ)


async def ticks(served, count=3):
    """Wait until the feed has sent what there is; somebody has to look at a page."""
    for _ in range(count):
        await asyncio.wait_for(served._tick.wait(), DEADLINE_S * stretch())


def run(scenario, monkeypatch):
    """Run scenario(parts, connect) with a feed; return the errors that it has reported.

    connect(robot) connects a page and returns its Socket; robot: default: that of the parts.
    """
    monkeypatch.setattr(feed, 'RATE_HZ', 200.0)
    errors = []

    async def serve():
        parts = Pictures(), Measurements(), Driver()
        served, sockets, tasks = Feed(parts[0], errors.append), [], []

        def connect(robot=Robot(*parts[1:])):
            sockets.append(Socket())
            tasks.append(asyncio.ensure_future(served.serve(sockets[-1], robot)))
            return sockets[-1]
        await scenario((served,) + parts, connect)
        for socket in sockets:
            socket.texts.put_nowait(None)
        results = await asyncio.gather(*tasks, return_exceptions=True)
        assert all(result is None or isinstance(result, Gone) for result in results)
        assert parts[0].watched == set() and not parts[1].is_watched
    asyncio.run(serve())
    return errors


def test_a_page_gets_new_pictures_and_measurements_when_it_is_ready(monkeypatch):
    async def scenario(parts, connect):
        served, pictures, measurements, _ = parts
        socket = connect()
        pictures.pictures = {CAMERA: Picture(1, b'jpeg 1'),
                             BLUE: Picture(7, b'blue')}
        measurements.add('asked', [1.0, 0.2, 0.0])
        measurements.set('factor', 1.0)
        socket.send(look=[CAMERA, BLUE])
        await ticks(served)
        assert socket.received == []                # not asked for yet
        assert pictures.watched == {CAMERA, BLUE} and measurements.is_watched
        socket.send(ready=1)
        await until(lambda: socket.received)
        (news, jpegs), = socket.received
        assert news['pictures'] == [[CAMERA, 6], [BLUE, 4]]
        assert jpegs == [b'jpeg 1', b'blue']
        assert news['measured'] == {'asked': [[1.0, 0.2, 0.0]], 'factor': 1.0}
        socket.send(ready=1)
        await ticks(served)
        assert len(socket.received) == 1            # nothing is new
        pictures.pictures[CAMERA] = Picture(2, b'jpeg 2')
        measurements.add('asked', [1.1, 0.3, 0.0])
        await until(lambda: len(socket.received) == 2)
        news, jpegs = socket.received[1]
        assert jpegs == [b'jpeg 2'] and news['measured'] == {'asked': [[1.1, 0.3, 0.0]]}
    run(scenario, monkeypatch)


def test_a_page_that_does_not_read_misses_frames_and_slows_nobody(monkeypatch):
    async def scenario(parts, connect):
        pictures = parts[1]
        slow, fast = connect(), connect()
        slow.reads.clear()
        for socket in (slow, fast):
            socket.send(look=[CAMERA])
        for number in range(5):
            for socket in (slow, fast):
                socket.send(ready=1)
            pictures.pictures[CAMERA] = Picture(number, b'%d' % number)
            await until(lambda number=number: len(fast.received) > number)
        assert [jpegs for _, jpegs in fast.received] == [[b'%d' % number] for number in range(5)]
        slow.reads.set()
        await until(lambda: len(slow.received) == 2)
        assert [jpegs for _, jpegs in slow.received] == [[b'0'], [b'4']]
    run(scenario, monkeypatch)


def test_pages_at_the_same_place_share_one_message(monkeypatch):
    composed = []

    async def scenario(parts, connect):
        served, pictures = parts[:2]
        compose = served._compose
        monkeypatch.setattr(served, '_compose',
                            lambda *args: composed.append(args) or compose(*args))
        sockets = [connect() for _ in range(20)]
        for socket in sockets:
            socket.send(look=[CAMERA])
            socket.send(ready=1)
        await ticks(served)
        composed.clear()
        pictures.pictures[CAMERA] = Picture(1, b'1')
        await ticks(served, 6)
        assert all(len(socket.received) == 1 for socket in sockets)
        assert sum(b'1' != b'' for _ in composed) <= 6      # one a tick, not one a page
        assert served.viewers == 20
    run(scenario, monkeypatch)


def test_each_page_gets_the_measurements_of_its_robot_and_drives_it(monkeypatch):
    async def scenario(parts, connect):
        other = Robot(Measurements(), Driver())
        first, second = connect(), connect(other)
        parts[2].set('pose', [1, 0, 0])
        other.measurements.set('pose', [2, 0, 0])
        for socket in (first, second):
            socket.send(look=[], ready=1)
        second.send(drive=[1, 0])
        await until(lambda: first.received and second.received and other.driving.calls)
        assert first.received == [({'pictures': [], 'measured': {'pose': [1, 0, 0]}}, [])]
        assert second.received == [({'pictures': [], 'measured': {'pose': [2, 0, 0]}}, [])]
        assert other.driving.calls == [(1.0, 0.0)] and parts[3].calls == []
        second.send(look=None)
        await until(lambda: not other.measurements.is_watched)
        assert parts[2].is_watched
    run(scenario, monkeypatch)


def test_nothing_is_measured_while_nobody_looks(monkeypatch):
    async def scenario(parts, connect):
        served, pictures, measurements, _ = parts
        socket = connect()
        socket.send(look=[CAMERA])
        await until(lambda: served.viewers == 1)
        assert measurements.is_watched
        socket.send(look=None)                      # a tab in the background
        await until(lambda: served.viewers == 0)
        assert pictures.watched == set() and not measurements.is_watched
        assert served._ticking is None
        socket.send(look=[])                        # no picture in sight
        await until(lambda: measurements.is_watched)
        assert pictures.watched == set()
    run(scenario, monkeypatch)


def test_driving_ends_with_the_connection(monkeypatch):
    async def scenario(parts, connect):
        driver, socket = parts[3], connect()
        socket.send(drive=[1, -0.5])
        socket.send(drive=[7, -7])
        socket.send(drive=None)
        socket.send(drive=[0.5, 0])
        await until(lambda: len(driver.calls) == 4)
        assert driver.calls == [(1.0, -0.5), (1.0, -1.0), None, (0.5, 0.0)]
        socket.texts.put_nowait(None)
        await until(lambda: len(driver.calls) == 5)
        assert driver.calls[-1] is None
    run(scenario, monkeypatch)


def test_who_may_not_drive_gets_to_know_it(monkeypatch):
    async def scenario(parts, connect):
        parts[3].is_free = False
        socket = connect()
        socket.send(ready=1, drive=[1, 0])
        await until(lambda: parts[3].calls)
        assert socket.received == [] and parts[0]._ticking is None      # it does not look
        socket.send(look=[])
        await until(lambda: socket.received)
        assert socket.received == [({'pictures': [], 'measured': {'busy': True}}, [])]
    run(scenario, monkeypatch)


MALFORMED = ['', 'null', '[]', '7', '"look"', '{', '{"look": "/camera"}', '{"look": [7]}',
             '{"look": {"a": 1}}', json.dumps({'look': ['/x' * 200]}),
             json.dumps({'look': ['/x'] * 33}), '{"look": [""]}', '{"look": ["camera"]}',
             '{"look": ["/a//b"]}', '{"look": ["/a/"]}', '{"look": ["/a\\u0000"]}',
             '{"look": ["/a\\n"]}', '{"look": ["~a"]}', '{"drive": [1' + '0' * 400 + ', 0]}',
             '{"drive": 1}', '{"drive": [1]}',
             '{"drive": [1, 2, 3]}', '{"drive": ["1", 0]}', '{"drive": [true, 0]}',
             '{"drive": [NaN, 0]}', '{"drive": [Infinity, 0]}', '{"drive": {"a": 1, "b": 2}}',
             '{"delete": "everything"}', '[' * 100000]


@pytest.mark.parametrize('text', MALFORMED)
def test_a_malformed_message_is_dropped(monkeypatch, text):
    async def scenario(parts, connect):
        driver, socket = parts[3], connect()
        socket.texts.put_nowait(text)
        socket.send(drive=[1, 1])
        await until(lambda: driver.calls)
        assert driver.calls == [(1.0, 1.0)] and socket.code is None
        viewer, = parts[0]._viewers
        assert viewer.malformed == 1 and viewer.names == () and not viewer.is_looking
    run(scenario, monkeypatch)


@pytest.mark.parametrize('nonsense', ['nonsense', b'bytes'])
def test_who_sends_only_malformed_messages_is_disconnected(monkeypatch, nonsense):
    async def scenario(parts, connect):
        socket = connect()
        for _ in range(feed._MAX_MALFORMED):
            socket.texts.put_nowait(nonsense)
        await until(lambda: socket.code is not None)
        assert socket.code == 1008
    assert run(scenario, monkeypatch) == []


def test_what_cannot_be_sent_ends_the_page_and_is_reported(monkeypatch):
    sockets = []

    async def scenario(parts, connect):
        parts[2].set('scan', {'angle_min': float('nan')})
        sockets.append(connect())
        sockets[0].send(look=[])
        sockets[0].send(ready=1)
        await until(lambda: sockets[0].code is not None)
    errors = run(scenario, monkeypatch)
    assert sockets[0].code == 1011
    assert len(errors) == 1 and 'not JSON compliant' in str(errors[0])
