"""The triangles of shapes: of primitive ones, and of meshes in their scale."""
from typing import Callable, Dict, List

import numpy as np

from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import Triangles
from img_recog.model import BOX, CYLINDER, MESH, PLANE, SPHERE, Shape

_SECTIONS = 48              # of a full circle


def of_shape(shape: Shape, read_file: Callable[[str], List[Triangles]] = mesh_file.read
             ) -> List[Triangles]:
    """Return the triangles of a shape; read_file: `mesh_file.read`, or a cache of it.

    Raises MeshError when its file cannot be read.
    """
    if shape.kind == MESH:
        scale = np.array(shape.size)
        return [_scaled(part, scale)
                for part in mesh_file.select(read_file(shape.path), shape.submesh)]
    return [_PRIMITIVES[shape.kind](*shape.size)]


def _scaled(part: Triangles, scale: np.ndarray) -> Triangles:
    normals = part.normals / np.where(scale == 0, 1e-12, scale)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
    # a mirrored triangle would face the other way
    order = slice(None, None, -1 if scale.prod() < 0 else 1)
    return part._replace(positions=(part.positions * scale)[:, order], normals=normals[:, order],
                         uvs=part.uvs[:, order])


def _flat(corners: np.ndarray, uvs: np.ndarray) -> Triangles:
    """Return quads (n, 4, 3), corners counterclockwise seen from outside, as triangles."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    order = [0, 1, 2, 0, 2, 3]
    return Triangles(corners[:, order].reshape(-1, 3, 3),
                     np.repeat(normals, 6, axis=0).reshape(-1, 3, 3),
                     uvs[:, order].reshape(-1, 3, 2))


_QUAD_UVS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


def _plane(x: float, y: float) -> Triangles:
    corners = np.append((_QUAD_UVS - 0.5) * (x, y), np.zeros((4, 1)), axis=1)
    return _flat(corners[None], _QUAD_UVS[None])


def _box(x: float, y: float, z: float) -> Triangles:
    faces = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            first, second = (axis + 1) % 3, (axis + 2) % 3
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[:, first], corners[:, second] = (_QUAD_UVS - 0.5).T
            faces.append(corners if side > 0 else corners[[1, 0, 3, 2]])
    corners = np.array(faces)
    uvs = np.array([_box_uvs(face, number // 2) for number, face in enumerate(corners)])
    return _flat(corners * (x, y, z), uvs)


def _box_uvs(face: np.ndarray, axis: int) -> np.ndarray:
    """Return where the corners of a side are on the texture, like in Gazebo.

    It is upright on the vertical sides; on the upper one, x is upward.
    """
    x, y, z = face.T
    side = face[0, axis]
    across = {0: y * np.sign(side), 1: -x * np.sign(side), 2: -y}[axis]
    upward = x * np.sign(side) if axis == 2 else z
    return np.column_stack([across + 0.5, upward + 0.5])


def _circle() -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, _SECTIONS + 1)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _cylinder(radius: float, length: float) -> Triangles:
    """Return a cylinder with the texture as in Gazebo: upside down, beginning at the y axis."""
    directions = _circle() @ [[0, 1], [-1, 0]]
    circle, z = directions * radius, length / 2
    low = np.column_stack([circle, np.full(len(circle), -z)])
    high = np.column_stack([circle, np.full(len(circle), z)])
    grid = np.stack([low, high])
    across = np.column_stack([directions, np.zeros(len(circle))])
    outward = np.stack([across, across])
    side = _grid(grid, outward)
    side = side._replace(uvs=1 - side.uvs)
    around = np.linspace(1, 0, len(circle))
    caps = []
    for ring, side_z in ((high, 1.0), (low, -1.0)):
        center = np.broadcast_to((0.0, 0.0, side_z * z), (_SECTIONS, 3))
        corners = np.stack([center, ring[:-1], ring[1:]], axis=1)
        edge = np.column_stack([around, np.full(len(circle), 0.0 if side_z > 0 else 1.0)])
        uvs = np.stack([np.broadcast_to((0.0, 1.0), (_SECTIONS, 2)), edge[:-1], edge[1:]], axis=1)
        if side_z < 0:      # counterclockwise seen from below
            corners, uvs = corners[:, ::-1], uvs[:, ::-1]
        normals = np.broadcast_to((0.0, 0.0, side_z), corners.shape)
        caps.append(Triangles(corners, normals, uvs))
    return _joined([side] + caps)


def _sphere(radius: float) -> Triangles:
    """Return a sphere whose poles are on the y axis, like those of Gazebo."""
    polar = np.linspace(-np.pi / 2, np.pi / 2, _SECTIONS // 2 + 1)
    circle = _circle()
    rings = []
    for angle in polar:
        along = np.full(len(circle), np.sin(angle))
        rings.append(np.column_stack([circle * np.cos(angle), along]))
    directions = np.stack(rings)[:, :, [1, 2, 0]]
    return _grid(directions * radius, directions)


def _grid(points: np.ndarray, normals: np.ndarray) -> Triangles:
    """Return a surface of points (rows, columns, 3), rows upward and columns counterclockwise."""
    rows, columns = points.shape[:2]
    uvs = np.stack(np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows)), axis=2)

    def corners(values: np.ndarray) -> np.ndarray:
        a, b = values[:-1, :-1], values[:-1, 1:]
        c, d = values[1:, 1:], values[1:, :-1]
        return np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3, values.shape[2])
    return Triangles(corners(points), corners(normals), corners(uvs))


def _joined(parts: List[Triangles]) -> Triangles:
    positions, normals, uvs = (np.concatenate(values)
                               for values in zip(*(part[:3] for part in parts)))
    return Triangles(positions, normals, uvs)


_PRIMITIVES: Dict[str, Callable[..., Triangles]] = {
    BOX: _box, CYLINDER: _cylinder, SPHERE: _sphere, PLANE: _plane}
