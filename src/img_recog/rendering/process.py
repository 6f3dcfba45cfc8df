"""A separate process that draws: the physics goes on meanwhile."""
import multiprocessing
from multiprocessing.connection import Connection
from typing import Any, Callable, List, NamedTuple, Optional, Sequence, Union

import numpy as np

from img_recog.errors import UserError
from img_recog.helper_process import HelperProcess
from img_recog.rendering.camera import Camera
from img_recog.rendering.renderer import make_or
from img_recog.visuals import VisualScene

_SLOTS = 2                  # one that is drawn into, and one that is read
_NICENESS = 5               # where OpenGL runs on the processor, the physics comes first
_FIRST_CAMERA = Camera(16, 16, 1.0)


class Shot(NamedTuple):
    """An image to be drawn.

    camera: the number of the camera; pose (4, 4): of its body in the world, see
    `opengl.Renderer.draw`; depth: whether its depths are wanted too.
    """

    camera: int
    pose: np.ndarray
    depth: bool = False


class Drawn(NamedTuple):
    """An image, uint8 RGB (height, width, 3), and float32 depths (height, width) in m or None.

    Valid until the second request after the one that it answers.
    """

    image: np.ndarray
    depth: Optional[np.ndarray]


class _Draw(NamedTuple):
    """The message that requests images into the slot of that number; see `request`."""

    slot: int
    shots: Sequence[Shot]
    poses: np.ndarray


class _Load(NamedTuple):
    """The message that another scene is drawn from now on."""

    scene: VisualScene
    poses: np.ndarray


class _Answer(NamedTuple):
    """The answer to a message, and the message that the process is ready.

    problem, advice: why it has ended, else ''; fallback_reason: why there is no OpenGL, else '';
    missing: a line for each visual of the scene that cannot be drawn.
    """

    problem: str = ''
    advice: str = ''
    fallback_reason: str = ''
    missing: Sequence[str] = ()


class DrawingError(UserError):
    """The process cannot draw."""


class ProcessEnded(DrawingError):
    """The process has ended by itself, or was killed."""


# Makes what draws like opengl.Renderer. Raises UserError where it cannot.
MakeRenderer = Callable[[], Any]


class DrawingProcess:
    """Draws the images of a request, one request at a time.

    Images come back through memory that both processes share. It is not a file: nothing is left
    over when a process is killed.

    fallback_reason: why there is no OpenGL, '' if there is; known when it is ready.
    """

    def __init__(self, scene: VisualScene, poses: np.ndarray, cameras: Sequence[Camera],
                 make_renderer: MakeRenderer, make_fallback: MakeRenderer):
        """Start it.

        poses (n, 7): of all parts at the start. make_fallback: used when make_renderer raises
        UserError. Both are functions of modules.
        """
        self._layout = _Layout(cameras)
        memory = multiprocessing.get_context('spawn').RawArray('B', self._layout.size * _SLOTS)
        self._bytes = np.frombuffer(memory, np.uint8)
        self._helper = HelperProcess(
            _serve, (scene, poses, list(cameras), make_renderer, make_fallback), _NICENESS,
            inherited=(memory,))
        self._requests = 0
        self._is_busy = False
        self._shots: List[Shot] = []
        self._missing: List[str] = []
        self.fallback_reason = ''

    @property
    def busy(self) -> bool:
        """Whether a request has not been answered."""
        return self._is_busy

    def wait_ready(self, timeout_s: Optional[float]) -> bool:
        """Return whether the scene is loaded within the time; to be called before `request`.

        Raises DrawingError when the process cannot draw or has ended.
        """
        answer = self._receive(timeout_s)
        if answer is None:
            return False
        self.fallback_reason = answer.fallback_reason
        return True

    def take_missing(self) -> List[str]:
        """Return new lines about visuals that cannot be drawn; known after an answer."""
        missing, self._missing = self._missing, []
        return missing

    def load(self, scene: VisualScene, poses: np.ndarray) -> None:
        """Draw another scene from now on; a request whose answer has no image.

        poses (n, 7): of all parts now.
        """
        self._send([], _Load(scene, poses))

    def request(self, shots: Sequence[Shot], poses: np.ndarray) -> None:
        """Request images of all parts at `poses` (n, 7); only when it is not busy."""
        self._requests += 1
        self._send(shots, _Draw(self._requests % _SLOTS, list(shots), poses))

    def _send(self, shots: Sequence[Shot], message: Union[_Draw, _Load]) -> None:
        self._shots, self._is_busy = list(shots), True
        self._helper.send(message)      # if the process has ended, `answer` raises the error

    def answer(self, timeout_s: Optional[float]) -> Optional[List[Drawn]]:
        """Return the images of the request in its order; None if they are not drawn in time.

        timeout_s: None waits for as long as it takes.
        Raises DrawingError when the process cannot draw or has ended.
        """
        if self._receive(timeout_s) is None:
            return None
        shots, self._shots, self._is_busy = self._shots, [], False
        slot = self._bytes[self._requests % _SLOTS * self._layout.size:]
        return [self._layout.drawn(slot, shot) for shot in shots]

    def _receive(self, timeout_s: Optional[float]) -> Optional[_Answer]:
        """Return the next answer of the process, None if there is none in time."""
        try:
            if not self._helper.connection.poll(timeout_s):
                return None
            answer: _Answer = self._helper.connection.recv()
        except (EOFError, OSError):
            raise ProcessEnded('the process that draws has ended with exit code {}'.format(
                self._helper.wait()))
        if answer.problem:
            raise DrawingError(answer.problem, answer.advice)
        self._missing += answer.missing
        return answer

    def kill(self) -> None:
        """End the process at once; the next call of `answer` raises ProcessEnded."""
        self._helper.kill()

    def close(self) -> None:
        """End the process."""
        self._helper.end()


class _Layout:
    """Where the images of cameras are in a slot."""

    def __init__(self, cameras: Sequence[Camera]):
        self._cameras = list(cameras)
        self._starts: List[int] = []
        self.size = 0
        for camera in cameras:
            self._starts.append(self.size)
            # RGB, and depths of 4 bytes at an address that is divisible by 4
            self.size += -(-camera.width * camera.height * 3 // 4) * 4 + (
                camera.width * camera.height * 4)

    def drawn(self, slot: np.ndarray, shot: Shot) -> Drawn:
        """Return the images of a shot in a slot."""
        camera, start = self._cameras[shot.camera], self._starts[shot.camera]
        pixels = camera.width * camera.height
        image = slot[start:start + 3 * pixels].reshape(camera.height, camera.width, 3)
        depth = None
        if shot.depth:
            begin = start + -(-3 * pixels // 4) * 4
            depth = slot[begin:begin + 4 * pixels].view(np.float32).reshape(
                camera.height, camera.width)
        return Drawn(image, depth)


def _serve(connection: Connection, memory: Any, scene: VisualScene, poses: np.ndarray,
           cameras: Sequence[Camera], make_renderer: MakeRenderer,
           make_fallback: MakeRenderer) -> None:
    """Draw until the other end of the connection is closed."""
    try:
        renderer, reason = make_or(make_renderer, make_fallback)
        missing = renderer.load(scene, poses)
        # OpenGL compiles its programs when they are first used: not while the simulation waits
        renderer.draw(_FIRST_CAMERA, np.eye(4), poses)
        renderer.depth(_FIRST_CAMERA, np.eye(4), poses)
        connection.send(_Answer(fallback_reason=reason, missing=missing))
        layout = _Layout(cameras)
        slots = np.frombuffer(memory, np.uint8).reshape(_SLOTS, layout.size)
        while True:
            message = connection.recv()
            if isinstance(message, _Load):
                connection.send(_Answer(missing=renderer.load(*message)))
                continue
            for shot in message.shots:
                image, depth = layout.drawn(slots[message.slot], shot)
                camera = cameras[shot.camera]
                image[:] = renderer.draw(camera, shot.pose, message.poses)
                if depth is not None:
                    depth[:] = renderer.depth(camera, shot.pose, message.poses)
            connection.send(_Answer())
    except (EOFError, OSError):
        pass
    except UserError as error:
        _send_error(connection, error)


def _send_error(connection: Connection, error: UserError) -> None:
    try:
        connection.send(_Answer(error.problem, error.advice))
    except OSError:
        pass
