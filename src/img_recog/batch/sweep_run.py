"""One run of a sweep: a closed loop in simulated time, judged while it runs."""
import contextlib
import dataclasses
import fnmatch
import functools
import math
import os
import tempfile
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog import files
from img_recog.batch.sweep_file import Run, Success, Values, given
from img_recog.batch.work_folder import digest, identity
from img_recog.errors import UserError, one_line
from img_recog.loading import assemble, resources, robot_file
from img_recog.recognition import parameter_file
from img_recog.rendering import prepared, renderer
from img_recog.rendering.light import LightSettings
from img_recog.replay import scenario
from img_recog.replay.chain import (SECOND_NS, Chain, ColorRecognition, FrameMeasurement,
                                    FrameResult, Recorder)
from img_recog.replay.film import Film, FilmRecorder
from img_recog.replay.robot_frames import RobotFrames
from img_recog.settings import from_mapping
from img_recog.simulation.pictures.footprints import footprints
from img_recog.simulation.simulation_settings import (CameraSettings, DriveSettings, NoiseSettings,
                                                      SpawnSettings)
from img_recog.simulation.simulator import Simulator

_MAX_SPEED = 100.0      # m/s; only the physics throws a robot that fast
_MAX_FALL_M = 10.0      # below the floor
_APART_S = 0.1          # without a contact, after which a touch is another one; else it bounces
REACHED, TIME, COLLISION, PATH = 'goal reached', 'time is up', 'collision', 'path too long'


class Result(NamedTuple):
    """How a run has ended, and where the robot was then.

    reason: REACHED or what failed; time_s: simulated; distance_m: to the goal; collisions: how
    often it has begun to touch something; path_m: how far it has driven; x_m, y_m, yaw_rad: in
    the world; touched: what it has touched first, '' for nothing.
    """

    reason: str
    time_s: float
    distance_m: float
    collisions: int
    path_m: float
    x_m: float
    y_m: float
    yaw_rad: float
    touched: str


class Judge(Recorder):
    """Follows the robot from image to image, until it has succeeded or failed.

    What it touches is noted at each step of the physics.
    """

    def __init__(self, simulator: Simulator, goal: str, success: Success):
        """Raise UserError if the world has no model `goal`."""
        self._simulator, self._success = simulator, success
        self._robot = simulator.robots[0].body
        bodies = simulator.world.scenery
        self._goals = [body for body in bodies if fnmatch.fnmatchcase(body.name, goal)]
        if not self._goals:
            raise UserError('the world has no model {}'.format(goal),
                            'it has ' + ', '.join(body.name for body in bodies))
        self._last: Optional[np.ndarray] = None
        self._touched_s: Dict[str, float] = {}      # when each was touched last
        self._collisions, self._path_m, self._touched = 0, 0.0, ''
        self.result = Result(TIME, 0.0, math.inf, 0, 0.0, math.nan, math.nan, math.nan, '')
        simulator.after_step = self._note_touched

    def _note_touched(self) -> None:
        touching = self._simulator.touched(self._robot)
        now_s = self._simulator.time_s
        new = [name for name in touching
               if now_s - self._touched_s.get(name, -math.inf) > _APART_S]
        self._collisions += len(new)
        self._touched = self._touched or ', '.join(new)
        self._touched_s.update(dict.fromkeys(touching, now_s))

    def on_frame(self, result: FrameResult) -> None:
        position = np.array(result.motion.position)
        self._refuse_thrown(position, result.motion.linear, result.time_ns)
        if self._last is not None:
            self._path_m += math.dist(position[:2], self._last[:2])
        self._last = position
        distance_m = min(math.dist(position[:2], goal.pose().position[:2])
                         for goal in self._goals)
        self.result = Result(
            self._reason(distance_m), result.time_ns / SECOND_NS, distance_m, self._collisions,
            self._path_m, float(position[0]), float(position[1]), result.motion.yaw,
            self._touched)

    def _reason(self, distance_m: float) -> str:
        if self._collisions > self._success.collisions:
            return COLLISION
        if 0 < self._success.path_length < self._path_m:
            return PATH
        return REACHED if distance_m <= self._success.distance else TIME

    @staticmethod
    def _refuse_thrown(position: np.ndarray, velocity: np.ndarray, time_ns: int) -> None:
        speed = float(np.linalg.norm(velocity))
        if not (speed <= _MAX_SPEED and position[2] >= -_MAX_FALL_M
                and np.isfinite(position).all()):
            raise UserError(
                'the physics has thrown the robot: at {:.2f} s it is at x {:.3g}, y {:.3g} and '
                'z {:.3g} m, with {:.3g} m/s'.format(time_ns / SECOND_NS, *position, speed),
                'see check_robot.py and check_world.py')

    def until_over(self, measurements: Iterable[FrameMeasurement]
                   ) -> Iterator[FrameMeasurement]:
        """Yield measurements until the run has succeeded or failed."""
        for measurement in measurements:
            yield measurement
            if self.result.reason != TIME:
                return


def run(paths: Sequence[str], roles: Tuple[str, ...], run: Run, success: Success,
        time_limit_s: float) -> Result:
    """Return how a run ends; for the engine.

    paths: files in the place of those of the parameters `roles`.
    Raises UserError if it cannot be run, or the robot is thrown.
    """
    return _run(_with_paths(run, roles, paths), success, time_limit_s, None)


def film(paths: Sequence[str], roles: Tuple[str, ...], run: Run, success: Success,
         time_limit_s: float) -> bytes:
    """Return the film of a run, an MP4; arguments and errors as for `run`."""
    with tempfile.NamedTemporaryFile(suffix='.mp4') as file:
        _run(_with_paths(run, roles, paths), success, time_limit_s, file)
        with open(file.name, 'rb') as written:
            return written.read()


def scene_of(values: Values) -> Tuple[str, str]:
    """Return the world and the URDF of a run, by its parameters."""
    return values.get('world', resources.DEFAULT_WORLD), values.get('urdf') or resources.burger()


@functools.lru_cache(maxsize=None)      # a program reads them once
def inputs(world: str, urdf: str) -> Tuple[str, Dict[str, str]]:
    """Return a hash of what a world and a robot are once they are read, and of their files.

    Also returns the identity of each of these files, by its path.
    world, urdf: as for scenario.build. What is included, expanded, found somewhere else, or not
    found any more makes another model, so only the files that the models name are left.
    """
    with files.noting() as noted:
        try:
            text = robot_file.read(urdf, '--urdf')
            robot, file = assemble.robot_of(text, urdf), assemble.world(world, allow_partial=False)
        except UserError as error:      # what cannot be read has no result
            return one_line(error), {path: identity(path) for path in sorted(noted)}
        models = [robot.model, *(tree.model for tree in file.trees)]
        paths = {path for model in models for named in model.files
                 for path in prepared.files_of(named)}
    found = digest((text, robot.model, file, [
        (path, os.path.isfile(path) and identity(path)) for path in sorted(paths)]))
    return found, {path: identity(path) for path in sorted(paths | noted)}


def _with_paths(run: Run, roles: Tuple[str, ...], paths: Sequence[str]) -> Run:
    return run._replace(parameters={**run.parameters, **dict(zip(roles, paths))})


@functools.lru_cache(maxsize=None)
def _renderer() -> Any:
    """Return that of this process: making one takes as long as 50 images."""
    return renderer.make()


def _run(run: Run, success: Success, time_limit_s: float, film_file: Any) -> Result:
    values = run.parameters
    simulator = scenario.build(*scene_of(values), from_mapping(SpawnSettings, values),
                               drive=given(DriveSettings, values), noise=NoiseSettings(run.seed))
    with contextlib.closing(simulator), contextlib.ExitStack() as stack:    # room for 1024
        camera = dataclasses.replace(scenario.camera_settings(simulator),
                                     **given(CameraSettings, values))
        frames = RobotFrames(simulator, camera, time_limit_s, from_mapping(LightSettings, values),
                             run.seed, _renderer())
        settings = parameter_file.read_or_default(values.get('colors', ''))
        judge = Judge(simulator, values['goal'], success)
        recorders: List[Recorder] = [judge]
        if film_file is not None:
            film = stack.enter_context(Film(film_file, settings, footprints(simulator.world)))
            recorders.append(FilmRecorder(film))
        chain = Chain(simulator, ColorRecognition(settings), bool(values.get('teleop')),
                      recorders)
        end_ns = chain.run(judge.until_over(chain.measured(frames))) + frames.period_ns
        chain.end(end_ns)
        if film_file is not None:
            film.close(end_ns / SECOND_NS)
    return judge.result
