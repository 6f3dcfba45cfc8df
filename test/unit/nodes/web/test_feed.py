"""What pages get and send over their WebSocket, with plain objects in place of ROS."""
import asyncio
import json
import time
from typing import NamedTuple, Tuple

import pytest

from img_recog.nodes.web import feed
from img_recog.nodes.web.feed import Feed
from img_recog.nodes.web.pictures import EncodedPicture
from img_recog.nodes.web.updates import Updates
from img_recog_helpers.waiting import DEADLINE_S, stretch

CAMERA, BLUE = '/usb_cam/image_raw', '/blue_image'
RATE_HZ = 200.0


def decoded(data):
    """Return what is measured and the pictures by their names, like the page does."""
    start = 4 + int.from_bytes(data[:4], 'big')
    message, jpegs = json.loads(data[4:start]), {}
    for name, size in message['pictures']:
        jpegs[name] = data[start:start + size]
        start += size
    return message['measured'], jpegs


class Pictures:
    def __init__(self):
        self.watched, self.pictures = set(), {}

    def watch(self, names):
        self.watched = names

    def latest(self, name):
        return self.pictures.get(name)


class Topics:
    def __init__(self):
        self.updates, self.is_watched = Updates(), False

    def watch(self, is_watched):
        self.is_watched = is_watched


class Driver:
    is_free = True

    def __init__(self):
        self.calls = []

    def hold(self, owner, linear, angular):
        self.calls.append((linear, angular))
        return self.is_free

    def release(self, owner):
        self.calls.append(None)


class Robot(NamedTuple):
    topics: Tuple[Topics, Topics]
    driving: Driver

    @property
    def updates(self):
        return self.topics[1].updates


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
    start_s = time.monotonic()
    while not condition():
        assert time.monotonic() < start_s + DEADLINE_S * stretch()
        await asyncio.sleep(1 / RATE_HZ)


async def some_periods():
    """Give the feed time to send what it should not."""
    await asyncio.sleep(10 / RATE_HZ)


class Served:
    """A feed, one robot and its pictures, and the pages that are connected."""

    def __init__(self):
        self.pictures, self.errors, self.tasks, self.sockets = Pictures(), [], [], []
        self.system = Topics()
        self.robot = self.other_robot()
        self.feed = Feed(self.pictures, self.errors.append)

    def other_robot(self):
        return Robot((self.system, Topics()), Driver())

    def connect(self, robot=None, **message):
        """Return the Socket of another page, which sends a message."""
        socket = Socket()
        self.sockets.append(socket)
        self.tasks.append(asyncio.ensure_future(self.feed.serve(socket, robot or self.robot)))
        if message:
            socket.send(**message)
        return socket


@pytest.fixture
def run(monkeypatch):
    """A function that runs scenario(served); it returns the errors that the feed has reported."""
    monkeypatch.setattr(feed, 'RATE_HZ', RATE_HZ)

    async def serve(scenario):
        served = Served()
        await scenario(served)
        for socket in served.sockets:
            socket.texts.put_nowait(None)
        results = await asyncio.gather(*served.tasks, return_exceptions=True)
        assert all(result is None or isinstance(result, Gone) for result in results)
        assert served.pictures.watched == set() and not served.system.is_watched
        return served.errors
    return lambda scenario: asyncio.run(serve(scenario))


def test_a_page_gets_new_pictures_and_measurements_when_it_is_ready(run):
    async def scenario(served):
        updates, pictures = served.robot.updates, served.pictures
        pictures.pictures = {CAMERA: EncodedPicture(1, b'jpeg 1'),
                             BLUE: EncodedPicture(7, b'blue')}
        updates.add('asked', [1.0, 0.2, 0.0])
        served.system.updates.set('factor', 1.0)
        socket = served.connect(look=[CAMERA, BLUE])
        await until(lambda: pictures.watched == {CAMERA, BLUE})
        await some_periods()
        assert socket.received == []                # not asked for yet
        socket.send(ready=1)
        await until(lambda: socket.received)
        assert socket.received == [({'asked': [[1.0, 0.2, 0.0]], 'factor': 1.0},
                                    {CAMERA: b'jpeg 1', BLUE: b'blue'})]
        socket.send(ready=1)
        await some_periods()
        assert len(socket.received) == 1            # nothing is new
        updates.add('asked', [1.1, 0.3, 0.0])
        await until(lambda: len(socket.received) == 2)
        pictures.pictures[CAMERA] = EncodedPicture(2, b'jpeg 2')
        socket.send(ready=1)
        await until(lambda: len(socket.received) == 3)
        assert socket.received[1:] == [({'asked': [[1.1, 0.3, 0.0]]}, {}),
                                       ({}, {CAMERA: b'jpeg 2'})]
    run(scenario)


def test_a_page_that_does_not_read_misses_frames_and_slows_nobody(run):
    async def scenario(served):
        slow, fast = served.connect(look=[CAMERA]), served.connect(look=[CAMERA])
        slow.reads.clear()
        for number in range(5):
            for socket in (slow, fast):
                socket.send(ready=1)
            served.pictures.pictures[CAMERA] = EncodedPicture(number, b'%d' % number)
            await until(lambda number=number: len(fast.received) > number)
        assert [jpegs for _, jpegs in fast.received] == [
            {CAMERA: b'%d' % number} for number in range(5)]
        slow.reads.set()
        await until(lambda: len(slow.received) == 2)
        assert [jpegs for _, jpegs in slow.received] == [{CAMERA: b'0'}, {CAMERA: b'4'}]
    run(scenario)


def test_each_page_gets_the_measurements_of_its_robot_and_drives_it(run):
    async def scenario(served):
        other = served.other_robot()
        served.robot.updates.set('pose', [1, 0, 0])
        other.updates.set('pose', [2, 0, 0])
        first = served.connect(look=[], ready=1)
        second = served.connect(other, look=[], ready=1, drive=[1, 0])
        await until(lambda: first.received and second.received and other.driving.calls)
        assert first.received == [({'pose': [1, 0, 0]}, {})]
        assert second.received == [({'pose': [2, 0, 0]}, {})]
        assert other.driving.calls == [(1.0, 0.0)] and served.robot.driving.calls == []
        second.send(look=None)
        await until(lambda: not other.topics[1].is_watched)
        assert served.robot.topics[1].is_watched and served.system.is_watched
    run(scenario)


def test_nothing_is_measured_while_nobody_looks(run):
    async def scenario(served):
        topics, socket = served.robot.topics[1], served.connect(look=[CAMERA], ready=1)
        await until(lambda: served.feed.viewers == 1)
        assert topics.is_watched
        socket.send(look=None)                      # a tab in the background
        await until(lambda: served.feed.viewers == 0)
        assert served.pictures.watched == set() and not topics.is_watched
        topics.updates.set('factor', 1.0)
        await some_periods()
        assert socket.received == []
        socket.send(look=[])                        # no picture in sight
        await until(lambda: topics.is_watched and socket.received)
        assert served.pictures.watched == set()
    run(scenario)


def test_driving_ends_with_the_connection(run):
    async def scenario(served):
        calls, socket = served.robot.driving.calls, served.connect(drive=[1, -0.5])
        for speeds in ([7, -7], None, [0.5, 0]):
            socket.send(drive=speeds)
        await until(lambda: len(calls) == 4)
        assert calls == [(1.0, -0.5), (1.0, -1.0), None, (0.5, 0.0)]
        socket.texts.put_nowait(None)
        await until(lambda: len(calls) == 5)
        assert calls[-1] is None
    run(scenario)


def test_who_may_not_drive_gets_to_know_it(run):
    async def scenario(served):
        served.robot.driving.is_free = False
        socket = served.connect(ready=1, drive=[1, 0])
        await until(lambda: served.robot.driving.calls)
        await some_periods()
        assert socket.received == []                # it does not look
        socket.send(look=[])
        await until(lambda: socket.received)
        assert socket.received == [({'busy': True}, {})]
    run(scenario)


@pytest.mark.parametrize('text', [
    '', 'null', '[]', '7', '"look"', '{', b'bytes', '{"look": "/camera"}', '{"look": [7]}',
    '{"look": {"a": 1}}', json.dumps({'look': ['/x' * 200]}), json.dumps({'look': ['/x'] * 33}),
    '{"look": [""]}', '{"look": ["camera"]}', '{"look": ["/a//b"]}', '{"look": ["/a/"]}',
    '{"look": ["/a\\u0000"]}', '{"look": ["/a\\n"]}', '{"look": ["~a"]}',
    '{"drive": [1' + '0' * 400 + ', 0]}', '{"drive": 1}', '{"drive": [1]}',
    '{"drive": [1, 2, 3]}', '{"drive": ["1", 0]}', '{"drive": [true, 0]}', '{"drive": [NaN, 0]}',
    '{"drive": [Infinity, 0]}', '{"drive": {"a": 1, "b": 2}}', '{"delete": "everything"}',
    '[' * 60000], ids=lambda text: str(text[:30]))
def test_malformed_messages_are_dropped_and_end_the_connection_at_last(run, text):
    async def scenario(served):
        calls, socket = served.robot.driving.calls, served.connect()
        for _ in range(19):
            socket.texts.put_nowait(text)
        socket.send(drive=[1, 1])
        await until(lambda: calls)
        assert calls == [(1.0, 1.0)] and socket.code is None
        assert served.feed.viewers == 0 and served.pictures.watched == set()
        socket.texts.put_nowait(text)
        await until(lambda: socket.code is not None)
        assert socket.code == 1008
    assert run(scenario) == []


def test_what_cannot_be_sent_ends_the_page_and_is_reported(run):
    async def scenario(served):
        served.robot.updates.set('scan', {'angle_min': float('nan')})
        socket = served.connect(look=[], ready=1)
        await until(lambda: socket.code is not None)
        assert socket.code == 1011
    error, = run(scenario)
    assert 'not JSON compliant' in str(error)
