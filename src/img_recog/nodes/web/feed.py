"""Sends pictures and measurements to the pages, and takes what their visitors do.

Independent of ROS. One WebSocket a page. A page asks for the next news when it has drawn the last:
a slow browser misses frames, and slows nobody down.
"""
import asyncio
import json
import math
import re
import struct
from typing import (Any, Callable, Dict, Hashable, Iterable, List, NamedTuple, Optional, Protocol,
                    Set, Tuple)

RATE_HZ = 15.0
_MAX_PICTURES, _MAX_NAME = 32, 300      # live.js asks for no more
_MAX_MALFORMED = 20             # messages, until the connection is closed
_REFUSED, _FAILED = 1008, 1011  # close codes of RFC 6455
_CACHE_SIZE = 8
_TOPIC = re.compile('(/[A-Za-z][A-Za-z0-9_]*)+')        # the full name of one
_LENGTH = struct.Struct('>I')


class Picture(NamedTuple):
    """An encoded image; number: of the image, to see whether it is a new one."""

    number: int
    jpeg: bytes


class Pictures(Protocol):
    """Where the pictures come from."""

    def watch(self, names: Set[str]) -> None:
        """Get images of these names from now on, and of no others."""

    def latest(self, name: str) -> Optional[Picture]:
        """Return the newest picture."""


class Measurements(Protocol):
    """Where the measurements come from."""

    def watch(self, is_watched: bool) -> None:
        """Start or stop to measure."""

    def since(self, cursor: Any) -> Tuple[Hashable, Dict[str, Any]]:
        """Return what is new since a call that returned this cursor, and the next cursor.

        cursor: None for all that there is.
        """


class Driver(Protocol):
    """Who drives the robot."""

    def hold(self, owner: object, linear: float, angular: float) -> bool:
        """Drive with these shares of the highest speeds, -1 to 1, for a moment.

        Return False if another owner drives.
        """

    def release(self, owner: object) -> None:
        """Stop the robot, if this owner drives it."""


class Socket(Protocol):
    """A WebSocket of Starlette."""

    async def receive_text(self) -> str:
        """Return the next message; raise an error when the connection ends."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a message, and wait while the browser does not read."""

    async def close(self, code: int = 1000) -> None:
        """Close the connection."""


class Robot(Protocol):
    """What a page shows, and drives."""

    @property
    def measurements(self) -> Measurements:
        """What is measured; robots may share it."""

    @property
    def driving(self) -> Driver:
        """Who drives it."""


class _Viewer:
    """A page that is connected."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.names: Tuple[str, ...] = ()
        self.is_looking = False
        self.is_ready = asyncio.Event()
        self.cursor: Any = None         # of the measurements that it has got
        self.numbers: Dict[str, int] = {}       # of the pictures that it has got
        self.malformed = 0
        self.is_refused = False         # another page drives


async def _received(socket: Socket) -> str:
    """Return the next message; '', which makes no sense, for one that is not a text."""
    try:
        return await socket.receive_text()
    except KeyError:        # Starlette, for bytes
        return ''


class Feed:
    """Serves all pages; to be used in one event loop."""

    def __init__(self, pictures: Pictures, failed: Callable[[Exception], None]):
        """Serve nobody yet; failed: is called with an unexpected error, which ends a page."""
        self._pictures, self._failed = pictures, failed
        self._measured: List[Measurements] = []         # that are watched
        self._viewers: Set[_Viewer] = set()
        self._tick = asyncio.Event()
        self._ticking: Optional[asyncio.Task] = None
        self._composed: Dict[tuple, Tuple[Hashable, Dict[str, int], bytes]] = {}

    @property
    def viewers(self) -> int:
        """The number of pages that somebody looks at."""
        # a copy: the event loop changes it
        return sum(viewer.is_looking for viewer in list(self._viewers))

    async def serve(self, socket: Socket, robot: Robot) -> None:
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
        viewer.is_looking = names is not None
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
        looking = [viewer for viewer in self._viewers if viewer.is_looking]
        self._pictures.watch({name for viewer in looking for name in viewer.names})
        measured: List[Measurements] = []
        for viewer in looking:
            if viewer.robot.measurements not in measured:
                measured.append(viewer.robot.measurements)
        for each in self._measured:
            if each not in measured:
                each.watch(False)
        for each in measured:
            each.watch(True)
        self._measured = measured
        if looking and self._ticking is None:
            self._ticking = asyncio.ensure_future(self._run())
        elif not looking and self._ticking is not None:
            self._ticking.cancel()
            self._ticking = None

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(1 / RATE_HZ)
            self._composed.clear()
            self._tick.set()
            self._tick = asyncio.Event()

    async def _send(self, viewer: _Viewer, socket: Socket) -> None:
        while True:
            await viewer.is_ready.wait()
            await self._tick.wait()
            try:
                if viewer.is_refused:
                    viewer.is_refused, data = False, _message({'busy': True}, [], [])
                else:
                    data = self._news(viewer) if viewer.is_looking else b''
            except Exception as error:
                self._failed(error)
                await socket.close(_FAILED)
                return
            if data:
                viewer.is_ready.clear()
                await socket.send_bytes(data)

    def _news(self, viewer: _Viewer) -> bytes:
        """Return what a viewer has not got yet, b'' if there is nothing new."""
        measurements = viewer.robot.measurements
        key = (id(measurements), viewer.names, viewer.cursor,
               tuple(sorted(viewer.numbers.items())))
        found = self._composed.get(key)
        if found is None:
            found = self._compose(measurements, viewer.names, viewer.cursor, viewer.numbers)
            if len(self._composed) < _CACHE_SIZE:
                self._composed[key] = found
        viewer.cursor, viewer.numbers, data = found
        return data

    def _compose(self, measurements: Measurements, names: Iterable[str], cursor: Any,
                 numbers: Dict[str, int]) -> Tuple[Hashable, Dict[str, int], bytes]:
        """Return cursor, numbers and message for those who are at this cursor and these numbers.

        The message: the length of a JSON text, the text, and the pictures that it lists.
        """
        next_cursor, measured = measurements.since(cursor)
        next_numbers, listed, jpegs = dict(numbers), [], []
        for name in names:
            picture = self._pictures.latest(name)
            if picture is not None and picture.number != numbers.get(name):
                next_numbers[name] = picture.number
                listed.append([name, len(picture.jpeg)])
                jpegs.append(picture.jpeg)
        if not listed and not measured:
            return next_cursor, next_numbers, b''
        return next_cursor, next_numbers, _message(measured, listed, jpegs)


def _message(measured: Dict[str, Any], listed: List[list], jpegs: List[bytes]) -> bytes:
    text = json.dumps({'pictures': listed, 'measured': measured},
                      separators=(',', ':'), allow_nan=False).encode()
    return b''.join([_LENGTH.pack(len(text)), text, *jpegs])


def _share(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(value)
    return max(-1.0, min(1.0, float(value)))
