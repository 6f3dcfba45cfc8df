"""The roads of an SDF world: strips that are only seen."""
import xml.etree.ElementTree as ElementTree

import numpy as np

from img_recog.errors import SimulationError
from img_recog.files import FindFile
from img_recog.formats import gazebo_materials, generated_meshes, materials
from img_recog.formats.reader import name_of, value, values
from img_recog.model import MESH, Link, Look, Model, Shape, Tree
from img_recog.report import Report
from img_recog.rotations import IDENTITY

_ABOVE_M = 0.005        # so that the floor is not seen in it
_ASPHALT = gazebo_materials.named('Gazebo/Road')


def tree(road: ElementTree.Element, find: FindFile, report: Report) -> Tree:
    """Return a <road> as a tree without a collision shape, like in Gazebo.

    find: returns the path of the file at a URI; report: to which is added a look that is not
    found. Raises SimulationError when a number is wrong, or it has fewer than two points.
    """
    name = 'road {}'.format(name_of(road)).strip()
    points = np.array(values(road, 'point')).reshape(-1, 3)
    width = value(road, 'width')
    if len(points) < 2:
        raise SimulationError('{} has {} points, expected 2 or more'.format(name, len(points)))
    material = materials.of_sdf(road, find, report)
    above = IDENTITY._replace(translation=np.array((0.0, 0.0, _ABOVE_M)))
    strip = Look(Shape(MESH, (1.0, 1.0, 1.0), _strip(points, width)), above, material or _ASPHALT)
    name = road.get('name', 'road')
    return Tree(name, Model(name, (Link('link', looks=(strip,)),)), fixed=True)


def _strip(points: np.ndarray, width: float) -> str:
    """Write the mesh of a strip along points (n, 3); return its path."""
    steps = np.diff(points[:, :2], axis=0)
    lengths = np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
    directions = steps / lengths[:, None]
    # at a corner, across the mean of both directions
    at_points = np.concatenate([directions[:1], directions[:-1] + directions[1:], directions[-1:]])
    across = np.column_stack([at_points[:, 1], -at_points[:, 0], np.zeros(len(points))])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    vertices = np.stack([points - across * width / 2, points + across * width / 2], axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)]) / (width or 1.0)
    left, right = np.zeros(len(points)), np.ones(len(points))
    uvs = np.stack([np.column_stack([left, along]), np.column_stack([right, along])], axis=1)
    return generated_meshes.write(vertices.reshape(-1, 3),
                                  generated_meshes.grid_faces(len(points), 2), uvs.reshape(-1, 2))
