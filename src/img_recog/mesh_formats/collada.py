"""COLLADA files; the scene and the materials are read as by ColladaLoader of Gazebo 11."""
import functools
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np

from img_recog.mesh_formats import collada_geometry
from img_recog.mesh_formats.collada_geometry import Arrays
from img_recog.mesh_formats.collada_materials import Materials, read_floats
from img_recog.mesh_formats.polygons import FilePart

_MAX_NODES = 200_000        # that nodes refer to
_MAX_CONTROLLERS = 10                           # that refer to one another


class _Group(NamedTuple):
    """What the instances of a geometry have in common.

    name: of the node that they are in; bound: (symbol, URL) of their materials.
    """

    geometry: ElementTree.Element
    name: str
    bound: Tuple[Tuple[str, str], ...]


def read(content: bytes, find_texture: Callable[[str], str], max_triangles: int
         ) -> Tuple[List[FilePart], int]:
    """Return what Gazebo draws of a COLLADA file, in m, and of how many triangles that is all.

    find_texture: returns the path of a texture of that name. Raises an error of any type if it
    cannot be read, or has more than that many triangles.
    """
    if b'<!ENTITY' in content or b'\0' in content:
        # entities within entities make a small file large; expat limits them from 2.4.0 on
        raise ValueError('it has entities, or is not UTF-8')
    document = _Document(ElementTree.fromstring(content.lstrip(b'\xef\xbb\xbf \t\r\n')))
    groups: Dict[_Group, List[np.ndarray]] = {}
    counts: Dict[int, int] = {}
    total = 0
    for group, pose in document.shapes():
        key = id(group.geometry)
        if key not in counts:
            counts[key] = collada_geometry.count_triangles(group.geometry)
        total += counts[key]
        if total > max_triangles:
            raise ValueError('it has more than {} triangles'.format(max_triangles))
        if np.isfinite(pose).all():
            groups.setdefault(group, []).append(pose)
    unit, materials = document.unit(), Materials(document.get, find_texture)
    read_once = functools.lru_cache(maxsize=None)(collada_geometry.read)
    parts = []
    for group, poses in groups.items():
        for symbol, arrays in read_once(group.geometry).items():
            url = dict(group.bound).get(symbol, symbol)
            positions, normals, uvs = _placed(arrays, np.array(poses))
            parts.append(FilePart(unit * positions, normals, uvs,
                                  materials.get(url) if symbol else None, group.name))
    return parts, total


class _Document:
    """The elements of a COLLADA file, without their namespace."""

    def __init__(self, root: ElementTree.Element):
        self._root = root
        self._named: Dict[Tuple[str, str], ElementTree.Element] = {}
        for element in root.iter():
            element.tag = element.tag.rpartition('}')[2]
            for key in ('id', 'sid'):
                if key in element.attrib:
                    self._named.setdefault((element.tag, element.attrib[key]), element)

    def get(self, tag: str, url: Optional[str]) -> Optional[ElementTree.Element]:
        """Return the element that is named so, with or without #; None without one."""
        name = (url or '').strip()      # a name may contain # as well
        return self._named.get((tag, name[1:] if name.startswith('#') else name))

    def unit(self) -> float:
        """Return the length of the unit in m."""
        element = self._root.find('asset/unit')
        unit = 1.0 if element is None else float(element.get('meter', '1'))
        if not unit > 0:
            raise ValueError('its unit has the length {:g}'.format(unit))
        return unit

    def shapes(self) -> Iterator[Tuple[_Group, np.ndarray]]:
        """Yield what the nodes of the scene show, and its pose (4, 4) in the scene."""
        instance = self._root.find('scene/instance_visual_scene')
        scene = None if instance is None else self.get('visual_scene', instance.get('url'))
        if scene is None:
            raise ValueError('it has no visual scene')
        waiting = [(node, np.eye(4), '') for node in reversed(scene.findall('node'))]
        count = 0
        while waiting:
            node, pose, name = waiting.pop()
            name = node.get('name', name)
            count += 1
            if count > _MAX_NODES:
                raise ValueError('it has more than {} nodes'.format(_MAX_NODES))
            pose = pose @ _transform(node)
            for child in node:
                if child.tag == 'node':
                    waiting.append((child, pose, name))
                elif child.tag == 'instance_node':
                    used = self.get('node', child.get('url'))
                    waiting += [] if used is None else [(used, pose, name)]
                elif child.tag in ('instance_geometry', 'instance_controller'):
                    yield from self._shape(child, pose, name)

    def _shape(self, instance: ElementTree.Element, pose: np.ndarray,
               name: str) -> Iterator[Tuple[_Group, np.ndarray]]:
        url = instance.get('url')
        if instance.tag == 'instance_controller':
            # the mesh of a skin, in the pose that it was bound in, or of a morph
            for _ in range(_MAX_CONTROLLERS):
                controller = self.get('controller', url)
                if controller is None or not len(controller):
                    break
                url = controller[0].get('source')
                matrix = controller[0].findtext('bind_shape_matrix')
                pose = pose if matrix is None else read_floats(matrix).reshape(4, 4) @ pose
        geometry = self.get('geometry', url)
        if geometry is not None:
            yield _Group(geometry, name, tuple(
                (each.get('symbol', ''), each.get('target', '')) for each in instance.findall(
                    'bind_material/technique_common/instance_material'))), pose


def _transform(node: ElementTree.Element) -> np.ndarray:
    """Return the transform (4, 4) of a node to its parent."""
    pose = np.eye(4)
    for child in node:
        step = np.eye(4)
        if child.tag == 'matrix':
            step = read_floats(child.text).reshape(4, 4)
        elif child.tag == 'translate':
            step[:3, 3] = read_floats(child.text)
        elif child.tag == 'scale':
            step[range(3), range(3)] = read_floats(child.text)
        elif child.tag == 'rotate':
            *axis, angle = read_floats(child.text)
            step[:3, :3] = _rotation(np.array(axis), np.radians(angle))
        pose = pose @ step
    return pose


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix of a rotation about an axis of any length (Rodrigues' formula)."""
    x, y, z = axis / max(float(np.linalg.norm(axis)), 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _placed(arrays: Arrays, poses: np.ndarray) -> List[np.ndarray]:
    """Return triangles at each pose (k, 4, 4)."""
    positions, normals, uvs = arrays
    turns = poses[:, None, :3, :3].transpose(0, 1, 3, 2)
    placed = [positions @ turns + poses[:, None, None, :3, 3], normals @ turns,
              np.repeat(uvs[None], len(poses), axis=0)]
    is_mirrored = np.linalg.det(poses[:, :3, :3]) < 0
    for each in placed:
        each[is_mirrored] = each[is_mirrored, :, ::-1]
    return [each.reshape(-1, *each.shape[2:]) for each in placed]
