"""The process that draws images, and a thread that waits for them."""
import enum
import math
import multiprocessing
import threading
import time
from typing import Callable, List, Optional, Sequence, Set, Tuple

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.errors import one_line
from img_recog.model import VisualScene
from img_recog.processes.helper_process import HelperProcess
from img_recog.rendering import renderer, server
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Answer, Picture, Request, Shot
from img_recog.ros import lifecycle
from img_recog.ros.diagnostics import EventCounter, Durations, add_counter, add_durations

_POLL_PERIOD_S = 0.1
_MAX_WAIT_S = 60.0          # for images, a scene or the start; then the process hangs
_WARN_AFTER_S = 5.0
_MAX_FAILURES = 3           # of processes, one after the other, that end before they draw
# OpenGL compiles its programs when they are first used: not while the simulation waits
_FIRST_SHOT = Shot(Camera(16, 16, 1.0), np.eye(4), depth=True)

Publish = Callable[[List[Picture]], None]


class _State(enum.Enum):
    """What the process does."""

    NOT_STARTED = 'it does not run'
    LOADING = 'it loads the first scene'
    READY = 'it waits for a request'
    BUSY = 'it draws, or loads another scene'
    ENDED = 'it does not run, and is not started again'


class ImageProcess:
    """Draws one request at a time in a process, and publishes its pictures in a thread.

    They come back through memory that both processes share. It is not a file: nothing is left
    over when a process is killed. A process that dies or hangs is replaced by the next `start`,
    unless three in a row have not drawn.

    `report` may be called in any thread, the other methods in that of the simulation.
    """

    def __init__(self, scene: VisualScene, poses: np.ndarray, cameras: Sequence[Camera],
                 niceness: int = 0, make: server.Make = renderer.make):
        """poses (n, 7): of all parts; niceness: how far other processes come first; make: makes
        what draws, in the process.
        """
        self._niceness = niceness
        self._scene, self._poses, self._cameras, self._make = scene, poses, cameras, make
        self._helper: Optional[HelperProcess] = None
        self._memory = np.empty((server.SLOTS, 0), np.uint8)
        self._thread: Optional[threading.Thread] = None
        # its lock is that of all attributes that change, except for those of _run alone
        self._condition = threading.Condition()
        self._state, self._is_scene_new = _State.NOT_STARTED, False
        self._request, self._requested_s = Request([], poses), 0.0
        self._lost: Optional[Tuple[Request, Publish]] = None
        self._publish: Optional[Publish] = None
        self._failures = 0
        self._said: Set[str] = set()
        self._problem = ''
        self._images, self._durations = EventCounter(), Durations()

    @property
    def is_ready(self) -> bool:
        """Whether it can draw; False until the scene is loaded, and after an error."""
        return self._is_in(_State.READY, _State.BUSY)

    @property
    def is_busy(self) -> bool:
        """Whether a request is being drawn, or a scene loaded."""
        return self._is_in(_State.LOADING, _State.BUSY)

    @property
    def is_loading(self) -> bool:
        """Whether it cannot draw yet."""
        return self._is_in(_State.NOT_STARTED, _State.LOADING)

    def _is_in(self, *states: _State) -> bool:
        with self._condition:
            return self._state in states

    def start(self) -> None:
        """Start the process, which loads the scene; no effect if it is started."""
        if not self._is_in(_State.NOT_STARTED):
            return
        try:
            memory = multiprocessing.get_context('spawn').RawArray(
                'B', server.SLOTS * self._memory_size())
            helper = HelperProcess(server.serve, (self._make,), self._niceness,
                                   inherited=(memory,))
        except OSError as error:        # too many open files, for example
            self._give_up('cannot start the process that draws: ' + one_line(error))
            return
        with self._condition:
            self._helper = helper
            self._memory = np.frombuffer(memory, np.uint8).reshape(server.SLOTS, -1)
            self._is_scene_new = True
            self._send(helper, Request([_FIRST_SHOT], self._poses), state=_State.LOADING)
        self._thread = threading.Thread(target=self._run, args=(helper,), name='drawing',
                                        daemon=True)
        self._thread.start()

    def _memory_size(self) -> int:
        return server.memory_size([*self._cameras, _FIRST_SHOT.camera])

    def set_scene(self, scene: VisualScene, poses: np.ndarray) -> None:
        """Draw another scene from now on; does not wait.

        It is loaded at once if nothing is drawn or loaded, else with the next request: of several
        scenes that come meanwhile, only the last one.
        """
        with self._condition:
            self._scene, self._poses, self._is_scene_new = scene, poses, True
            if self._state is _State.READY and self._helper is not None:
                self._send(self._helper, Request([], poses))

    def set_cameras(self, cameras: Sequence[Camera]) -> None:
        """Draw for other cameras from now on; waits until earlier images are drawn.

        If they need more memory, another process is started for them, with the next `start`.
        """
        with self._condition:
            self._cameras = cameras
            if self._helper is not None and self._memory_size() > self._memory.shape[1]:
                if self.is_ready:
                    self._wait_idle()
                self._drop()

    def _drop(self) -> None:
        """Use another process from the next `start` on; the thread of this one ends it."""
        if self.is_busy and self._publish is not None and self._lost is None:
            self._lost = self._request, self._publish
        self._helper = None
        if self._state is not _State.ENDED:
            self._state = _State.NOT_STARTED

    def draw(self, shots: Sequence[Shot], poses: np.ndarray, publish: Publish) -> None:
        """Draw all parts at `poses` (n, 7); waits until the pictures before are drawn.

        publish: is called in the thread; the pictures, in the order of the shots, are valid until
        it returns.
        """
        with self._condition:
            self._lost = Request(shots, poses), publish
        self.draw_again()

    @property
    def has_lost(self) -> bool:
        """Whether the last request of `draw` was lost with a process."""
        with self._condition:
            return self._lost is not None

    def draw_again(self) -> None:
        """Draw what was lost."""
        with self._condition:
            if self.is_ready and self._wait_idle() and self._helper is not None and self._lost:
                request, publish = self._lost
                self._lost = None
                self._send(self._helper, request, publish)

    def _send(self, helper: HelperProcess, request: Request, publish: Optional[Publish] = None,
              state: _State = _State.BUSY) -> None:
        scene = self._scene if self._is_scene_new else None
        self._is_scene_new = False
        # of two slots, the other one may still be published
        self._request = request._replace(slot=1 - self._request.slot, scene=scene)
        self._publish, self._requested_s, self._state = publish, time.monotonic(), state
        helper.send(self._request)      # if the process has ended, the thread notices

    def _wait_idle(self) -> bool:
        """Wait until nothing is drawn; return whether there may be a next request."""
        begin_s, warn_after_s = time.monotonic(), _WARN_AFTER_S
        while self.is_busy and not rospy.is_shutdown():
            self._condition.wait(_POLL_PERIOD_S)
            waited_s = time.monotonic() - begin_s
            if self.is_busy and waited_s > warn_after_s:
                warn_after_s = math.inf
                rospy.logwarn('the simulation waits for images: the process that draws has not '
                              'answered for %.0f s; it is replaced after %.0f s', waited_s,
                              _MAX_WAIT_S)
        return self._state is not _State.ENDED and not rospy.is_shutdown()

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add to a status what was drawn; to be called once in each period."""
        add_counter(status, 'images', self._images)
        add_durations(status, 'drawing', self._durations)
        with self._condition:
            problem = self._problem
        if problem:
            status.mergeSummary(DiagnosticStatus.WARN, 'no more images: ' + problem)

    def close(self) -> None:
        """End the process."""
        with self._condition:
            self._state = _State.ENDED
            self._condition.notify_all()
        if self._thread is not None:
            self._thread.join()

    def _run(self, helper: HelperProcess) -> None:
        """Take the answers of a process until it is replaced or has ended."""
        try:
            while self._is_used(helper):
                answer = self._receive(helper)
                if answer is None:
                    break
                if answer.problem:
                    self._give_up(answer.problem)
                else:
                    self._take(helper, answer)
        finally:
            helper.end()
            with self._condition:
                if self._helper is helper:
                    self._drop()
                    self._condition.notify_all()

    def _is_used(self, helper: HelperProcess) -> bool:
        with self._condition:
            return self._state is not _State.ENDED and self._helper is helper

    def _receive(self, helper: HelperProcess) -> Optional[Answer]:
        """Return the next answer of a process, None if it is not used any more or has ended."""
        try:
            while self._is_used(helper):
                if helper.connection.poll(_POLL_PERIOD_S):
                    return helper.connection.recv()
                with self._condition:
                    waited_s = time.monotonic() - self._requested_s
                if self.is_busy and waited_s > _MAX_WAIT_S:
                    helper.kill()       # a defect of a driver, for example
        except (EOFError, OSError):
            if self._is_used(helper):
                self._failed('the process that draws has ended with exit code {}'.format(
                    helper.wait()))
        return None

    def _failed(self, problem: str) -> None:
        self._failures += 1
        if self._failures < _MAX_FAILURES:
            rospy.logwarn('%s; it is started again', problem)
        else:
            self._give_up(problem)

    def _give_up(self, problem: str) -> None:
        with self._condition:
            self._state, self._problem = _State.ENDED, problem
            self._condition.notify_all()
        rospy.logwarn('no more images: %s; the simulation goes on without them', problem)

    def _take(self, helper: HelperProcess, answer: Answer) -> None:
        """Log what an answer says, and publish its pictures."""
        for line in answer.missing:
            if line not in self._said:
                self._said.add(line)
                rospy.logwarn('not drawn: %s', line)
        with self._condition:
            if not self._is_used(helper):
                return
            request, publish = self._request, self._publish
            pictures = server.pictures(self._memory[request.slot], request.shots)
            duration_s = time.monotonic() - self._requested_s
            self._state = _State.READY
            self._condition.notify_all()
        if publish is not None:
            self._durations.add(duration_s)
            self._failures = 0
            with lifecycle.until_shutdown():
                publish(pictures)
            self._images.add(len(pictures))
