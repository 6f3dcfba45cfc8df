"""Images that a separate process draws, and a thread publishes."""
import math
import threading
import time
from typing import Callable, List, NamedTuple, Optional, Sequence, Set

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.errors import one_line
from img_recog.rendering import renderer
from img_recog.rendering.camera import Camera
from img_recog.rendering.process import DrawingError, DrawingProcess, Drawn, ProcessEnded, Shot
from img_recog.ros.diagnostics import Counter, Durations, add_counter, add_durations
from img_recog.simulation.pictures.tiny_renderer import TinyRenderer
from img_recog.visuals import VisualScene

_POLL_PERIOD_S = 0.1
_MAX_WAIT_S = 60.0          # for images, a scene or the start; then the process hangs
_WARN_AFTER_S = 5.0
_MAX_FAILURES = 3           # of processes, one after the other, that end before they draw


class Job(NamedTuple):
    """An image to be drawn, and what to do with it: publish(drawn) is called in a thread."""

    shot: Shot
    publish: Callable[[Drawn], None]


class Drawing:
    """Draws jobs, one request at a time, in a process.

    A process that dies is replaced by the next `start`, unless three in a row have not drawn.

    `report` may be called in any thread, the other methods in that of the simulation.
    """

    def __init__(self, scene: VisualScene, poses: np.ndarray, cameras: Sequence[Camera]):
        self._scene, self._poses, self._cameras = scene, poses, list(cameras)
        self._process: Optional[DrawingProcess] = None
        self._jobs: List[Job] = []
        self._condition = threading.Condition()
        self._is_ready = self._has_ended = self._is_busy = False
        self._failures = 0
        self._said: Set[str] = set()
        self._thread: Optional[threading.Thread] = None
        self._make_extra_job: Optional[Callable[[float], Job]] = None
        self._requested_s, self._problem = 0.0, ''
        self._images, self._durations = Counter(), Durations()

    @property
    def is_ready(self) -> bool:
        """Whether it can draw; False until the scene is loaded, and after an error."""
        return self._is_ready and not self._has_ended

    @property
    def is_busy(self) -> bool:
        """Whether a request is being drawn."""
        return self._is_busy

    def start(self) -> None:
        """Start the process, which loads the scene; no effect if it is started."""
        if self._process is None and not self._has_ended:
            try:
                process = DrawingProcess(self._scene, self._poses, self._cameras, renderer.make,
                                         TinyRenderer)
            except OSError as error:        # too many open files, for example
                self._give_up('cannot start the process that draws: ' + one_line(error))
                return
            self._process = process
            self._thread = threading.Thread(target=self._run, args=(process,), name='drawing',
                                            daemon=True)
            self._thread.start()

    def set_scene(self, scene: VisualScene, poses: np.ndarray) -> None:
        """Draw another scene from now on; waits until earlier images are drawn.

        A process that still loads is replaced by the next `start`: to wait for it takes longer.
        """
        with self._condition:
            self._scene, self._poses = scene, poses
            if not self._is_ready:
                self._drop()
            elif self._wait_idle() and self._process is not None:
                self._jobs, self._is_busy = [], True
                self._process.load(scene, poses)

    def set_cameras(self, cameras: Sequence[Camera]) -> None:
        """Draw for other cameras from now on; waits until earlier images are drawn.

        Another process is started for them, with the next `start`.
        """
        with self._condition:
            if list(cameras) != self._cameras:
                if self._jobs:
                    self._wait_idle()
                self._cameras = list(cameras)
                self._drop()

    def _drop(self) -> None:
        """Use another process from the next `start` on; the thread of this one ends it."""
        self._process, self._is_ready, self._is_busy, self._jobs = None, False, False, []

    def add_to_next(self, make_job: Callable[[float], Job]) -> None:
        """Draw one more image with the next request; its time in s is the argument of make_job.

        It replaces an earlier one that is not requested yet.
        """
        self._make_extra_job = make_job

    def submit(self, jobs: Sequence[Job], poses: np.ndarray, time_s: float) -> None:
        """Request images of all parts at `poses` (n, 7); waits until those before are drawn.

        time_s: the simulated time of the poses.
        """
        make_job, self._make_extra_job = self._make_extra_job, None
        with self._condition:
            if not self._wait_idle() or self._process is None:
                return
            self._jobs = [*jobs, make_job(time_s)] if make_job is not None else list(jobs)
            self._is_busy = True
            self._requested_s = time.monotonic()
            self._process.request([job.shot for job in self._jobs], poses)

    def _wait_idle(self) -> bool:
        """Wait until nothing is drawn; return whether there may be a next request."""
        begin_s = time.monotonic()
        warn_after_s, kill_after_s = _WARN_AFTER_S, _MAX_WAIT_S
        while self._is_busy and not rospy.is_shutdown():
            self._condition.wait(_POLL_PERIOD_S)
            waited_s = time.monotonic() - begin_s
            if self._is_busy and waited_s > warn_after_s:
                warn_after_s = math.inf
                rospy.logwarn('the simulation waits for images: the process that draws has not '
                              'answered for %.0f s; it is replaced after %.0f s', waited_s,
                              kill_after_s)
            if self._is_busy and waited_s > kill_after_s and self._process is not None:
                kill_after_s = math.inf
                self._process.kill()        # a defect of a driver, for example
        return not self._has_ended and not rospy.is_shutdown()

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add to a status what was drawn; to be called once in each period."""
        add_counter(status, 'images', self._images)
        add_durations(status, 'drawing', self._durations)
        if self._problem:
            status.mergeSummary(DiagnosticStatus.WARN, 'no more images: ' + self._problem)

    def close(self) -> None:
        """End the process."""
        with self._condition:
            self._has_ended = True
            self._condition.notify_all()
        if self._thread is not None:
            self._thread.join()

    def _run(self, process: DrawingProcess) -> None:
        try:
            self._wait_ready(process)
            while self._is_in_use(process):
                self._take_answer(process)
        except DrawingError as error:
            if self._is_in_use(process):
                self._failed(error)
        finally:
            process.close()
            with self._condition:
                if self._process is process:
                    self._process, self._is_ready, self._is_busy = None, False, False
                    self._condition.notify_all()

    def _is_in_use(self, process: DrawingProcess) -> bool:
        return not self._has_ended and self._process is process

    def _failed(self, error: DrawingError) -> None:
        self._failures += 1
        if isinstance(error, ProcessEnded) and self._failures < _MAX_FAILURES:
            rospy.logwarn('%s; it is started again', one_line(error))
        else:
            self._give_up(one_line(error))

    def _give_up(self, problem: str) -> None:
        self._has_ended, self._problem = True, problem
        rospy.logwarn('no more images: %s; the simulation goes on without them', problem)

    def _wait_ready(self, process: DrawingProcess) -> None:
        end_s = time.monotonic() + _MAX_WAIT_S
        while self._is_in_use(process):
            if process.wait_ready(_POLL_PERIOD_S):
                if process.fallback_reason:
                    rospy.logwarn('images are drawn without shadows, and slowly: %s',
                                  process.fallback_reason)
                self._warn_of_missing(process)
                with self._condition:
                    self._is_ready = self._is_in_use(process)
                return
            if time.monotonic() > end_s:
                end_s = math.inf
                process.kill()

    def _take_answer(self, process: DrawingProcess) -> None:
        drawn = process.answer(_POLL_PERIOD_S)
        if drawn is None:
            return
        self._warn_of_missing(process)
        if drawn:
            self._durations.add(time.monotonic() - self._requested_s)
        with self._condition:
            jobs, self._is_busy = self._jobs, False
            self._jobs = []
            self._condition.notify_all()
        for job, image in zip(jobs, drawn):
            self._failures = 0
            job.publish(image)
            self._images.add()

    def _warn_of_missing(self, process: DrawingProcess) -> None:
        """Log what cannot be drawn, each line once."""
        for reason in process.take_missing():
            if reason not in self._said:
                self._said.add(reason)
                rospy.logwarn('not drawn: %s', reason)
