"""What of a simulation can be drawn, and how large it is."""
import collections
import functools
from typing import Dict, List, Optional, Set, Tuple

import numpy as np

from img_recog import rotations
from img_recog.checks.check_report import SIMULATED, CheckRow
from img_recog.errors import UserError, one_line
from img_recog.formats import materials
from img_recog.formats.meshes import mesh_file
from img_recog.model import Visual
from img_recog.rendering import triangles
from img_recog.report import NOT_DRAWN
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.simulator import Simulator


Box = Optional[np.ndarray]      # the lowest and the highest corner (2, 3), None if not drawn


def read(simulator: Simulator) -> Tuple[CheckRow, List[Box]]:
    """Read all that there is to draw; the world's report gets the files that cannot be read.

    Returns:
        A row with how much there is to draw, and the box of each body, in the order of the world.
    """
    parts = Parts(simulator)
    visuals, poses, reader = parts.scene().visuals, parts.poses(), _Reader()
    corners: Dict[int, List[np.ndarray]] = collections.defaultdict(list)
    for visual in visuals:
        corners[visual.part].append(_placed(reader.positions(visual), visual.pose,
                                            poses[visual.part]))
    boxes = [_box([each for number in numbers.values() for each in corners[number]])
             for numbers in parts.numbers()]
    row = CheckRow(
        SIMULATED, 'drawn', '{} shapes, {} triangles, {} mesh files, {} textures'.format(
            len(visuals), reader.triangles, len(reader.meshes), len(reader.textures)))
    for problem in reader.problems:
        simulator.world.report.add(NOT_DRAWN, problem)
    return row, boxes


class _Reader:
    """Reads meshes and textures, each once."""

    def __init__(self) -> None:
        self.triangles = 0
        self.meshes: Set[str] = set()
        self.textures: Set[str] = set()
        self.problems: Dict[str, None] = {}
        self._read = functools.lru_cache(maxsize=None)(mesh_file.read)

    def positions(self, visual: Visual) -> np.ndarray:
        """Return the corners (n, 3) of a visual in its own frame."""
        try:
            parts = triangles.of_shape(visual.shape, self._read)
        except UserError as error:
            self.problems[one_line(error)] = None
            return np.empty((0, 3))
        self.meshes |= {visual.shape.path} - {''}
        for part in parts:
            self.problems.update({part.problem: None} if part.problem else {})
            self._check_texture(part.material.texture)
        self._check_texture('' if visual.material is None else visual.material.texture)
        self.triangles += sum(len(part.positions) for part in parts)
        return np.concatenate([part.positions.reshape(-1, 3) for part in parts])

    def _check_texture(self, path: str) -> None:
        if not path or path in self.textures:
            return
        try:
            materials.read_texture(path)
            self.textures.add(path)
        except UserError as error:
            self.problems[one_line(error)] = None


def _placed(corners: np.ndarray, pose: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return corners (n, 3) in the world; pose (4, 4): in the part, whose pose (7,) is given."""
    in_part = corners @ pose[:3, :3].T + pose[:3, 3]
    return in_part @ rotations.matrix(part[3:]).T + part[:3]


def _box(corners: List[np.ndarray]) -> Optional[np.ndarray]:
    found = np.concatenate(corners) if corners else np.empty((0, 3))
    return np.array([found.min(axis=0), found.max(axis=0)]) if len(found) else None


def size(box: Box) -> str:
    """Return the size of a box, in m.

    >>> size(np.array([(0, 0, 0), (1, 0.25, 2)]))
    '1 x 0.25 x 2 m'
    """
    if box is None:
        return 'not drawn'
    return ' x '.join('{:.4g}'.format(round(top - bottom, 4))
                      for bottom, top in box.T) + ' m'
