"""The shapes of an SDF link, as elements of a URDF."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional, Tuple

import numpy as np

from img_recog import rotations
from img_recog.files import FindFile
from img_recog.mesh_file import READABLE
from img_recog.simulation.descriptions import link_materials, materials
from img_recog.simulation.descriptions.geometry import Transform
from img_recog.simulation.descriptions.numbers import read_lengths, read_numbers
from img_recog.simulation.settings import SimulationError

_PLANE_THICKNESS_M = 0.01       # below the plane
PLANE = 'plane'     # the attribute of a box that is a plane, the upper side of it

Geometry = Tuple[ElementTree.Element, Transform]


class Unsupported(Exception):
    """Something of an SDF that cannot be had; the text names it."""


def add(link: ElementTree.Element, shape: ElementTree.Element, pose: Transform, find: FindFile,
        concave: bool) -> str:
    """Add an SDF <visual> or <collision> to the <link> of a URDF; return what is missing or ''.

    pose: of the shape in the link's frame. find: returns the path of the file or folder at a URI.
    concave: whether a collision mesh is not replaced by its convex hull.
    Raises Unsupported when there is no such shape; SimulationError when a number is wrong.
    """
    geometry, offset = _geometry(shape, find)
    added = ElementTree.SubElement(link, shape.tag, name=shape.get('name', ''))
    added.append(origin(pose @ offset))
    ElementTree.SubElement(added, 'geometry').append(geometry)
    if shape.tag == 'collision':
        if concave and geometry.tag == 'mesh':
            added.set('concave', 'yes')
        return ''
    if geometry.tag == 'mesh' and not materials.is_given(shape):
        return ''       # the file has materials
    material, missing = materials.of_sdf(shape, find)
    added.append(link_materials.element(material))
    return missing


def origin(pose: Transform) -> ElementTree.Element:
    """Return a URDF's <origin>."""
    return ElementTree.Element('origin', xyz=_words(pose.translation),
                               rpy=_words(rotations.to_rpy(pose.rotation)))


def _geometry(shape: ElementTree.Element, find: FindFile) -> Geometry:
    """Return the element in a URDF's <geometry>, and its pose in the frame of the shape."""
    geometry = shape.find('geometry')
    if geometry is None or not len(geometry):
        raise Unsupported('<{} {}> has no geometry'.format(shape.tag, shape.get('name', '')))
    element = geometry[0]
    make = _MAKERS.get(element.tag)
    if make is None:
        raise Unsupported('<{}> of {} {}'.format(element.tag, shape.tag, shape.get('name', '')))
    name = '{} {}'.format(shape.tag, shape.get('name', ''))
    return make(name, element, find)


def _size(name: str, element: ElementTree.Element, tag: str, count: int) -> np.ndarray:
    values = read_lengths('<{}> of {}'.format(tag, name), element.findtext(tag), count)
    if np.any(values <= 0):
        raise SimulationError('<{}> of {}: got {!r}, expected more than 0'.format(
            tag, name, element.findtext(tag)))
    return values


def _box(name: str, element: ElementTree.Element, _: FindFile) -> Geometry:
    return (ElementTree.Element('box', size=_words(_size(name, element, 'size', 3))),
            Transform(np.eye(3), np.zeros(3)))


def _cylinder(name: str, element: ElementTree.Element, _: FindFile) -> Geometry:
    (radius,), (length,) = (_size(name, element, tag, 1) for tag in ('radius', 'length'))
    return (ElementTree.Element('cylinder', radius=repr(float(radius)),
                                length=repr(float(length))),
            Transform(np.eye(3), np.zeros(3)))


def _sphere(name: str, element: ElementTree.Element, _: FindFile) -> Geometry:
    (radius,) = _size(name, element, 'radius', 1)
    return (ElementTree.Element('sphere', radius=repr(float(radius))),
            Transform(np.eye(3), np.zeros(3)))


def _plane(name: str, element: ElementTree.Element, _: FindFile) -> Geometry:
    """Return a thin box, whose upper side is the plane."""
    normal = read_numbers('<normal> of ' + name, element.findtext('normal', '0 0 1'), 3)
    if not np.any(normal):
        raise SimulationError('<normal> of {}: got 0 0 0, expected a direction'.format(name))
    size = [1.0, 1.0]
    if element.find('size') is not None:
        size = _size(name, element, 'size', 2).tolist()
    rotation = _turn_z_to(normal / np.linalg.norm(normal))
    box = ElementTree.Element('box', {'size': _words((*size, _PLANE_THICKNESS_M)), PLANE: 'true'})
    return (box, Transform(rotation, rotation @ (0, 0, -_PLANE_THICKNESS_M / 2)))


def _turn_z_to(direction: np.ndarray) -> np.ndarray:
    """Return the shortest rotation that turns the z axis to a direction."""
    x, y, z = direction
    if z < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    return np.array([[1 - x * x / (1 + z), -x * y / (1 + z), x],
                     [-x * y / (1 + z), 1 - y * y / (1 + z), y], [-x, -y, z]])


def _mesh(name: str, element: ElementTree.Element, find: FindFile) -> Geometry:
    uri = (element.findtext('uri') or element.findtext('filename') or '').strip()
    path = find(uri)
    if path is None or not os.path.isfile(path):
        raise Unsupported('mesh ' + uri)
    if not path.lower().endswith(READABLE):
        raise Unsupported('mesh {} ({} are read)'.format(uri, ', '.join(READABLE)))
    scale = read_lengths('<scale> of ' + name, element.findtext('scale', '1 1 1'), 3)
    return (ElementTree.Element('mesh', filename=os.path.abspath(path), scale=_words(scale)),
            Transform(np.eye(3), np.zeros(3)))


_MAKERS: Dict[str, Callable[[str, ElementTree.Element, FindFile], Geometry]] = {
    'box': _box, 'cylinder': _cylinder, 'sphere': _sphere, 'plane': _plane, 'mesh': _mesh}


def _words(values) -> str:
    return ' '.join(repr(float(value)) for value in values)


def find_relative(folder: str, find: FindFile) -> Callable[[str], Optional[str]]:
    """Return a function that finds URIs, and paths relative to `folder`; files and folders."""
    def found(uri: str) -> Optional[str]:
        path = uri[len('file://'):] if uri.startswith('file://') else uri
        if '://' not in path:
            joined = os.path.join(folder, path)
            return joined if path and os.path.exists(joined) else None
        return find(uri)
    return found
