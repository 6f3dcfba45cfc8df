"""Sends pictures and measurements to the pages, and takes what their visitors do.

One WebSocket a page. A page asks for the next message when it has drawn the last: a slow browser
misses frames, and slows nobody down.
"""
import asyncio
import json
import math
import re
import struct
import time
from typing import Any, Callable, Dict, List, Optional, Set, Tuple

from starlette.websockets import WebSocket

from img_recog.nodes.web.measurements import WatchedTopics
from img_recog.nodes.web.pictures import RATE_HZ, PictureTopics
from img_recog.nodes.web.shown_robots import ShownRobot

_MAX_PICTURES, _MAX_NAME = 32, 300      # page.js asks for no more
_MAX_MALFORMED = 20             # messages, until the connection is closed
_REFUSED, _FAILED = 1008, 1011  # close codes of RFC 6455
_TOPIC = re.compile('(/[A-Za-z][A-Za-z0-9_]*)+')        # the full name of one
_LENGTH = struct.Struct('>I')


class _Viewer:
    """A page that is connected."""

    def __init__(self, robot: ShownRobot) -> None:
        self.robot = robot
        self.names: Tuple[str, ...] = ()
        self.is_looking, self.is_ready = asyncio.Event(), asyncio.Event()
        # what it has got: of the measurements, and of the pictures
        self.cursors: Dict[WatchedTopics, Optional[int]] = dict.fromkeys(robot.topics)
        self.numbers: Dict[str, int] = {}
        self.malformed = 0
        self.is_refused = False         # another page drives


async def _received(socket: WebSocket) -> str:
    """Return the next message; '', which makes no sense, for one that is not a text."""
    try:
        return await socket.receive_text()
    except KeyError:        # Starlette, for bytes
        return ''


class Feed:
    """Serves all pages; to be used in one event loop."""

    def __init__(self, pictures: PictureTopics, failed: Callable[[Exception], None]):
        """Serve nobody yet; failed: is called with an unexpected error, which ends a page."""
        self._pictures, self._failed = pictures, failed
        self._watched: Set[WatchedTopics] = set()
        self._viewers: Set[_Viewer] = set()

    @property
    def viewers(self) -> int:
        """The number of pages that somebody looks at."""
        # a copy: the event loop changes it
        return sum(viewer.is_looking.is_set() for viewer in list(self._viewers))

    async def serve(self, socket: WebSocket, robot: ShownRobot) -> None:
        """Serve a page until its connection ends; the errors of the connection are raised."""
        viewer = _Viewer(robot)
        self._viewers.add(viewer)
        sender = asyncio.ensure_future(self._send(viewer, socket))
        try:
            while viewer.malformed < _MAX_MALFORMED and not sender.done():
                self._take(viewer, await _received(socket))
            await socket.close(_REFUSED)
        finally:
            self._viewers.discard(viewer)
            robot.driving.release(viewer)
            self._update()
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)

    def _take(self, viewer: _Viewer, text: str) -> None:
        """Do what a message says; count it if it makes no sense."""
        try:
            message = json.loads(text)
            if not isinstance(message, dict):
                raise TypeError(message)
            actions = {key: self._ACTIONS[key] for key in message}
            for key, action in actions.items():
                action(self, viewer, message[key])
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
            viewer.malformed += 1

    def _look(self, viewer: _Viewer, names: Any) -> None:
        """None: nobody looks at the page; else the names of the pictures that can be seen."""
        if names is not None and not (
                isinstance(names, list) and len(names) <= _MAX_PICTURES
                and all(isinstance(name, str) and len(name) <= _MAX_NAME
                        and _TOPIC.fullmatch(name) for name in names)):
            raise ValueError(names)
        (viewer.is_looking.clear if names is None else viewer.is_looking.set)()
        viewer.names = tuple(names or ())
        viewer.numbers = {}
        self._update()

    def _ready(self, viewer: _Viewer, _: Any) -> None:
        viewer.is_ready.set()

    def _drive(self, viewer: _Viewer, speeds: Any) -> None:
        """None: released; else the shares of the highest speeds, linear and angular."""
        if speeds is None:
            viewer.robot.driving.release(viewer)
            return
        linear, angular = (_share(speed) for speed in speeds)
        viewer.is_refused = not viewer.robot.driving.hold(viewer, linear, angular)

    _ACTIONS: Dict[str, Callable[['Feed', _Viewer, Any], None]] = {
        'look': _look, 'ready': _ready, 'drive': _drive}

    def _update(self) -> None:
        """Get only what somebody looks at."""
        looking = [viewer for viewer in self._viewers if viewer.is_looking.is_set()]
        self._pictures.watch({name for viewer in looking for name in viewer.names})
        watched: Set[WatchedTopics] = {
            topics for viewer in looking for topics in viewer.robot.topics}
        for topics in self._watched - watched:
            topics.watch(False)
        for topics in watched:
            topics.watch(True)
        self._watched = watched

    async def _send(self, viewer: _Viewer, socket: WebSocket) -> None:
        due_s = 0.0
        while True:
            await viewer.is_ready.wait()
            await viewer.is_looking.wait()
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))
            due_s = max(due_s + 1 / RATE_HZ, time.monotonic())
            try:
                data = self._message(viewer) if viewer.is_looking.is_set() else b''
            except Exception as error:
                self._failed(error)
                await socket.close(_FAILED)
                return
            if data:
                viewer.is_ready.clear()
                await socket.send_bytes(data)

    def _message(self, viewer: _Viewer) -> bytes:
        """Return what a viewer has not got yet, b'' if there is nothing new.

        The length of a JSON text, the text, and the pictures that it lists.
        """
        if viewer.is_refused:
            viewer.is_refused = False
            return _encoded({'busy': True}, [], [])
        measured: Dict[str, Any] = {}
        for topics, cursor in viewer.cursors.items():
            viewer.cursors[topics], found = topics.updates.since(cursor)
            measured.update(found)
        listed, jpegs = [], []
        for name in viewer.names:
            picture = self._pictures.latest(name)
            if picture is not None and picture.number != viewer.numbers.get(name):
                viewer.numbers[name] = picture.number
                listed.append([name, len(picture.jpeg)])
                jpegs.append(picture.jpeg)
        return _encoded(measured, listed, jpegs) if listed or measured else b''


def _encoded(measured: Dict[str, Any], listed: List[list], jpegs: List[bytes]) -> bytes:
    text = json.dumps({'pictures': listed, 'measured': measured},
                      separators=(',', ':'), allow_nan=False).encode()
    return b''.join([_LENGTH.pack(len(text)), text, *jpegs])


def _share(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(value)
    return max(-1.0, min(1.0, float(value)))
