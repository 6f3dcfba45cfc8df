"""Print all that the simulator makes of robots and worlds, as text to be compared.

usage: golden.py [--hashes] FILE ...
       golden.py --compare | --write [FOLDER]

FILE is a URDF, a xacro file, an SDF or the name of a world. With --hashes, a line for each file
has the hash of its text. Made before a change of structure, and again after it, the two must be
equal.

test/golden.txt has the hashes of this package's own files, and of public ones, which are not kept
here. --compare prints a line for each file that differs now. Public files are compared if FOLDER
is given: it has a clone of each repository of the list, at the commit there, in OWNER+NAME.
--write writes the list again.
"""
import dataclasses
import hashlib
import logging
import os
import re
import subprocess
import sys
from typing import Any, Iterator, List, NamedTuple

import numpy as np
import pybullet

from img_recog.command_line import programs
from img_recog.errors import UserError, one_line
from img_recog.formats.world_file import EMPTY
from img_recog.loading import assemble
from img_recog.report import LEFT_OUT
from img_recog.simulation.models import Figures
from img_recog.simulation.physics.body import Body
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
LIST = os.path.join(ROOT, 'test', 'golden.txt')
_OWN = '.'
# of clones, the folders of models, like in GAZEBO_MODEL_PATH
_MODELS = 'ROBOTIS-GIT+turtlebot3_simulations/turtlebot3_gazebo/models', 'osrf+gazebo_models'
_SMALLEST = 1e-8        # what is nearer to 0 is rounding
# what is in the middle of two texts, as 0.123455 often is in a file, gets the same one of them
# however its last bit is rounded
_UPWARD = 1 + 1e-7


def text_of(path: str) -> str:
    """Return the text of a file, or why it is refused."""
    try:
        is_robot = path.endswith(('.urdf', '.xacro'))
        return '\n'.join(_robot(path) if is_robot else _world(path)) + '\n'
    except UserError as error:
        return 'refused: {}\n'.format(one_line(error))


def _robot(path: str) -> Iterator[str]:
    spec = assemble.robot(path)
    simulator = assemble.simulator(PhysicsSettings(world=EMPTY), [spec])
    yield from ('warning ' + line for line in simulator.world.report.lines())
    robot = simulator.robots[0]
    yield 'drive ' + _plain(dataclasses.asdict(spec.settings.drive))
    for sensor in (each for each in spec.sensors if not each.kind.is_drawn):
        yield 'sensor {} on {} {}'.format(sensor.name, _plain(sensor.place),
                                          _plain(robot.settings.sensors[sensor.name]))
    yield from ('camera ' + _plain(camera) for camera in spec.cameras)
    yield from _bodies(simulator)


def _world(path: str) -> Iterator[str]:
    simulator = assemble.simulator(PhysicsSettings(world=path, allow_partial_world=True))
    file = simulator.world.file
    yield from ('warning ' + line for line in simulator.world.report.lines())
    yield from ('left out ' + line for line in simulator.world.report.of(LEFT_OUT))
    yield 'gravity {} floor {} camera {}'.format(_plain(file.gravity), file.has_floor,
                                                 _plain(file.camera))
    yield from _bodies(simulator)


def _bodies(simulator: Simulator) -> Iterator[str]:
    figures = Figures(simulator)
    for what, values in (('link', figures.links()), ('joint', figures.joints()),
                         ('mass', figures.masses())):
        yield from ('{} {} {}'.format(what, *map(_plain, each)) for each in values.items())
    for body in simulator.world.bodies:
        yield from ('body {} {}'.format(body.name, line) for line in _of_body(body))
    parts = Parts(simulator)
    for visual in parts.scene().visuals:
        yield 'visual ' + _plain(visual)
    simulator.close()


def _of_body(body: Body) -> Iterator[str]:
    client = {'physicsClientId': body.physics_client_id}
    yield 'fixed {}'.format(body.fixed)
    for link in body.links:
        dynamics = pybullet.getDynamicsInfo(body.body_id, link, **client)
        box = pybullet.getAABB(body.body_id, link, **client)
        joint: List[Any] = []
        if link >= 0:
            info = pybullet.getJointInfo(body.body_id, link, **client)
            joint = [info[1].decode(), *info[2:3], *info[6:11], *info[12:17]]
        shapes = [(shape[2], shape[3], shape[5], shape[6]) for shape in
                  pybullet.getCollisionShapeData(body.body_id, link, **client) or ()]
        yield 'part {} joint {} friction {} bounce {} box {} shapes {}'.format(
            link, _plain(joint), *map(_plain, (dynamics[1], dynamics[5], box, shapes)))


def _plain(value: Any) -> str:
    """Return a value as text in which small differences of floating point do not matter."""
    if isinstance(value, bytes):
        return value.decode(errors='replace')
    if isinstance(value, (float, np.floating)):
        value = float(value)
        return '{:.5g}'.format(value * _UPWARD if abs(value) > _SMALLEST else 0.0)
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return '{{{}}}'.format(', '.join('{}: {}'.format(*map(_plain, item))
                                         for item in value.items()))
    if isinstance(value, (list, tuple)):
        return '({})'.format(' '.join(map(_plain, value)))
    if hasattr(value, 'matrix'):
        return _plain(value.matrix())
    return re.sub('/[^ ]*/', '', str(value))       # where the files are does not matter


class Golden(NamedTuple):
    """A file with the hash of its text; repository, commit: '.' and '-' for an own file."""

    hash: str
    repository: str
    commit: str
    path: str

    @property
    def place(self) -> str:
        """Its path in the folder of all clones, or in this package."""
        return os.path.normpath(os.path.join(self.repository.replace('/', '+'), self.path))


def read() -> List[Golden]:
    """Return the list."""
    with open(LIST) as file:
        return [Golden(*line.split()) for line in file if not line.startswith('#')]


def of_now(goldens: List[Golden], folder: str = '') -> List[Golden]:
    """Return them with the hashes of now, 'not read' where there is none.

    folder: of the clones; '' if the public files are not read.
    """
    found = {line[-1]: line[0] for is_own, start in ((True, ROOT), (False, folder)) if start
             for line in _lines(os.path.abspath(start), [
                 each.place for each in goldens if (each.repository == _OWN) == is_own], is_own)}
    return [each._replace(hash=found.get(each.place, 'not read')) for each in goldens]


def _lines(folder: str, places: List[str], is_own: bool) -> List[List[str]]:
    models = [] if is_own else [os.path.join(folder, each) for each in _MODELS]
    path = os.environ.get('ROS_PACKAGE_PATH', '') if is_own else os.pathsep.join(
        [folder, os.path.abspath(ROOT)])
    run = subprocess.run(
        [sys.executable, os.path.abspath(__file__), '--hashes', *places],
        cwd=folder, stdout=subprocess.PIPE, check=True, universal_newlines=True,
        env={**os.environ, 'ROS_PACKAGE_PATH': path, 'GAZEBO_RESOURCE_PATH': '',
             'GAZEBO_MODEL_PATH': os.pathsep.join(models)})
    return [words for words in map(str.split, run.stdout.splitlines()) if len(words) == 4]


def main() -> int:
    """Print the texts or their hashes, or compare; return 1 if something differs."""
    parser = programs.parser('golden.py', 'See the text at the head of this file.')
    for name in ('--hashes', '--compare', '--write'):
        parser.add_argument(name, action='store_true')
    parser.add_argument('files', nargs='*', metavar='FILE')
    given = parser.parse_args()
    if given.write or given.compare:
        folder = ''.join(given.files[:1])
        before = [each for each in read() if folder or each.repository == _OWN]
        after = of_now(before, folder)
        differ = [(old, new) for old, new in zip(before, after) if old != new]
        for old, new in differ:
            sys.stdout.write('{}: {}, expected {}\n'.format(old.place, new.hash, old.hash))
        if given.write:
            with open(LIST) as file:
                text = file.read()
            for old, new in differ:
                text = text.replace(' '.join(old), ' '.join(new))
            with open(LIST, 'w') as file:
                file.write(text)
        return 1 if differ else 0
    logging.disable(logging.CRITICAL)
    for path in given.files:
        text = text_of(path)
        sys.stdout.write('{} {} lines {}\n'.format(
            hashlib.sha256(text.encode()).hexdigest()[:16], text.count('\n'), path)
            if given.hashes else '== {}\n{}'.format(path, text))
        sys.stdout.flush()
    return 0


if __name__ == '__main__':
    sys.exit(main())
