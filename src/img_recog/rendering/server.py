"""What runs in the process that draws: it answers requests, one at a time."""
import math
from multiprocessing.connection import Connection
from typing import Any, Callable, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.model import VisualScene
from img_recog.rendering import lens_views
from img_recog.rendering.camera import Camera

SLOTS = 2                   # one that is drawn into, and one that is read
_BYTES_PER_PIXEL = 8        # RGB, and a depth at an address that is divisible by 4

# uint8 RGB (height, width, 3), and float32 depths (height, width) in m, or None
Picture = Tuple[np.ndarray, Optional[np.ndarray]]
# Makes what draws like opengl.Renderer; raises UserError if it cannot. A function of a module.
Make = Callable[[], Any]


class Shot(NamedTuple):
    """A picture to be drawn.

    pose (4, 4): of the camera body in the world, see `opengl.Renderer.draw`; depth: whether its
    depths are wanted too; ceiling: the height in m from which on nothing is drawn.
    """

    camera: Camera
    pose: np.ndarray
    depth: bool = False
    ceiling: float = math.inf


class Request(NamedTuple):
    """The pictures of all parts at `poses` (n, 7).

    scene: to be loaded before, else that of the last request is drawn; slot: of the memory, into
    which they are drawn.
    """

    shots: Sequence[Shot]
    poses: np.ndarray
    scene: Optional[VisualScene] = None
    slot: int = 0


class Answer(NamedTuple):
    """The answer to a request, whose pictures are in the memory.

    missing: a line for each visual of a new scene that cannot be drawn; problem: why nothing can
    be drawn, else ''.
    """

    missing: Sequence[str] = ()
    problem: str = ''


def memory_size(cameras: Sequence[Camera]) -> int:
    """Return how many bytes a picture of each camera needs, with depths.

    >>> memory_size([Camera(640, 480, 1.0), Camera(10, 10, 1.0)])
    2458400
    """
    return sum(camera.width * camera.height for camera in cameras) * _BYTES_PER_PIXEL


def pictures(memory: np.ndarray, shots: Sequence[Shot]) -> List[Picture]:
    """Return where the pictures of shots are in a slot of the memory, uint8 (n,)."""
    found: List[Picture] = []
    for shot in shots:
        size = shot.camera.height, shot.camera.width
        pixels, depth = size[0] * size[1], None
        if shot.depth:
            depth = memory[4 * pixels:8 * pixels].view(np.float32).reshape(size)
        found.append((memory[:3 * pixels].reshape(*size, 3), depth))
        memory = memory[_BYTES_PER_PIXEL * pixels:]
    return found


def serve(connection: Connection, memory: Any, make: Make) -> None:
    """Answer requests until the other end of the connection is closed.

    memory: the bytes of all slots, which both processes share.
    """
    # the threads of OpenCV wait in a busy loop, on a processor that others wait for
    cv2.setNumThreads(1)
    try:
        renderer = make()
        slots = np.frombuffer(memory, np.uint8).reshape(SLOTS, -1)
        while True:
            request = connection.recv()
            missing = ([] if request.scene is None
                       else renderer.load(request.scene, request.poses))
            for shot, (image, depth) in zip(request.shots,
                                            pictures(slots[request.slot], request.shots)):
                image[:] = lens_views.draw(renderer, shot.camera, shot.pose, request.poses,
                                           shot.ceiling)
                if depth is not None:
                    depth[:] = lens_views.depth(renderer, shot.camera, shot.pose, request.poses)
            connection.send(Answer(missing))
    except (EOFError, OSError):
        pass
    except UserError as error:
        _send_problem(connection, one_line(error))


def _send_problem(connection: Connection, problem: str) -> None:
    try:
        connection.send(Answer(problem=problem))
    except OSError:
        pass
