"""What is in a link of an SDF: its mass and its shapes."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional, Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.files import FindFile, no_file
from img_recog.formats import generated_meshes, heightmaps, inertias, materials
from img_recog.formats.meshes.mesh_file import READABLE
from img_recog.formats.numbers import (read_direction, read_lengths, read_mass, read_number,
                                       read_share)
from img_recog.formats.sdf_frames import pose_of
from img_recog.formats.texts import is_true, name_of, text_of
from img_recog.model import (ALL_BITS, BOX, CYLINDER, HEIGHTMAP, MESH, PLANE, SPHERE, WHITE,
                             Inertia, Look, Shape, Solid, Submesh)
from img_recog.report import Report
from img_recog.rotations import IDENTITY, Transform

_Geometry = Tuple[Shape, Transform]


def inertia(link: ElementTree.Element, offset: Transform, report: Report) -> Inertia:
    """Return the inertia of a link.

    offset: of the link in the frame in which the inertia is returned. report: gets a finding if it
    cannot be simulated as it is.
    """
    name = name_of(link)
    given = link.find('inertial')
    if given is None:
        given = ElementTree.Element('inertial')
    mass = read_mass('<mass> of link ' + name, given.findtext('mass', '1'))
    inertias.check_mass('<mass> of link ' + name, mass)
    matrix = np.array([read_number(
        '<{}> of link {}'.format(key, name),
        given.findtext('inertia/' + key, '1' if key[1] == key[2] else '0'))
        for key in inertias.INERTIA_KEYS]).reshape(3, 3)
    return Inertia(mass, offset @ pose_of(given),
                   inertias.possible('link ' + name, mass, matrix, report))


def decay(link: ElementTree.Element) -> Tuple[float, float]:
    """Return the shares of its velocities that a link loses in each step, see Link."""
    linear, angular = (read_share('<{}> of link {}'.format(tag, name_of(link)),
                                  link.findtext('velocity_decay/' + tag, '0'))
                       for tag in ('linear', 'angular'))
    return linear, angular


def solid(collision: ElementTree.Element, pose: Transform, find: FindFile) -> Solid:
    """Return a <collision>; pose: in the frame in which it is returned.

    find: returns the path of the file or folder at a URI. What carries of a heightmap is at the
    middle of its heights.
    Raises SimulationError when it cannot be had, or a number is wrong.
    """
    shape, offset = _geometry(collision, find)
    if shape.kind == HEIGHTMAP:
        middle = np.array((0.0, 0.0, heightmaps.read(shape).middle))
        offset = offset @ IDENTITY._replace(translation=middle)
    return Solid(shape, pose @ offset, bitmask=bitmask(collision))


def bitmask(collision: ElementTree.Element) -> int:
    """Return that of a <collision>, see Solid."""
    if is_true(collision.findtext('surface/contact/collide_without_contact')):
        return 0
    text = collision.findtext('surface/contact/collide_bitmask', hex(ALL_BITS)).strip()
    try:
        return int(text, 0) & ALL_BITS
    except ValueError:
        raise SimulationError('<collide_bitmask> of {}: got {!r}, expected a whole number'.format(
            name_of(collision), text))


def look(visual: ElementTree.Element, pose: Transform, find: FindFile, report: Report) -> Look:
    """Return a <visual>; arguments and errors as for `solid`.

    report: gets a finding if its material is not found.
    """
    shape, offset = _geometry(visual, find)
    material = materials.of_sdf(visual, find, report)
    opacity = materials.opacity(visual)
    if shape.kind == HEIGHTMAP:
        if material is None:
            material = heightmaps.material(visual.findall('geometry/*')[0], find)
        shape = Shape(MESH, (1.0, 1.0, 1.0), heightmaps.write_mesh(shape))
    if material is None and shape.kind == MESH:         # the file has materials
        return Look(shape, pose @ offset, opacity=opacity)
    return Look(shape, pose @ offset, material or WHITE.faded(opacity))


def _geometry(shape: ElementTree.Element, find: FindFile) -> _Geometry:
    """Return a shape, and its pose in the frame of the <visual> or <collision>."""
    name, geometry = '{} {}'.format(shape.tag, name_of(shape)), shape.find('geometry')
    if geometry is None or not len(geometry):
        raise SimulationError('<{}> has no geometry'.format(name))
    element = geometry if geometry[0].tag == 'polyline' else geometry[0]
    make = _MAKERS.get(geometry[0].tag)
    if make is None:
        raise SimulationError('<{}> of {}'.format(element.tag, name))
    return make(name, element, find)


def _size(name: str, element: ElementTree.Element, tag: str, count: int) -> Tuple[float, ...]:
    values = read_lengths('<{}> of {}'.format(tag, name), element.findtext(tag), count)
    if np.any(values <= 0):
        raise SimulationError('<{}> of {}: got {!r}, expected more than 0'.format(
            tag, name, element.findtext(tag)))
    return tuple(values.tolist())


def _box(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(BOX, _size(name, element, 'size', 3)), IDENTITY


def _cylinder(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(CYLINDER, (*_size(name, element, 'radius', 1),
                            *_size(name, element, 'length', 1))), IDENTITY


def _sphere(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(SPHERE, _size(name, element, 'radius', 1)), IDENTITY


def _plane(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    size = (1.0, 1.0) if element.find('size') is None else _size(name, element, 'size', 2)
    direction = _normal(name, element)
    return Shape(PLANE, size), IDENTITY._replace(
        rotation=turn_z_to(direction / np.linalg.norm(direction)))


def normal(collision: ElementTree.Element) -> Optional[np.ndarray]:
    """Return the normal (3,) of a <collision> that is a plane, as it is given; None of others."""
    plane = collision.find('geometry/plane')
    return None if plane is None else _normal('collision ' + name_of(collision), plane)


def _normal(name: str, plane: ElementTree.Element) -> np.ndarray:
    return read_direction('<normal> of ' + name, plane.findtext('normal', '0 0 1'))


def turn_z_to(direction: np.ndarray) -> np.ndarray:
    """Return the shortest rotation that turns the z axis to a direction."""
    x, y, z = direction
    if z < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    return np.array([[1 - x * x / (1 + z), -x * y / (1 + z), x],
                     [-x * y / (1 + z), 1 - y * y / (1 + z), y], [-x, -y, z]])


def _mesh(name: str, element: ElementTree.Element, find: FindFile) -> _Geometry:
    uri = (element.findtext('uri') or element.findtext('filename') or '').strip()
    path = find(uri)
    if path is None or not os.path.isfile(path):
        raise SimulationError('mesh ' + uri + no_file(path))
    if not path.lower().endswith(READABLE):
        raise SimulationError('mesh {} ({} are read)'.format(uri, ', '.join(READABLE)))
    scale = read_lengths('<scale> of ' + name, element.findtext('scale', '1 1 1'), 3)
    submesh = text_of(element, 'submesh/name')
    is_centered = is_true(element.findtext('submesh/center'))
    return Shape(MESH, tuple(scale.tolist()), os.path.abspath(path),
                 Submesh(submesh, bool(submesh) and is_centered)), IDENTITY


def _polyline(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    """Return the prism of all <polyline>s in a <geometry>; the height of the first counts."""
    outlines = [[read_lengths('<point> of ' + name, point.text, 2).tolist()
                 for point in polyline.findall('point')]
                for polyline in element.findall('polyline')]
    (height,) = _size(name, element[0], 'height', 1)
    return Shape(MESH, (1.0, 1.0, 1.0), generated_meshes.extruded(outlines, height)), IDENTITY


_MAKERS: Dict[str, Callable[[str, ElementTree.Element, FindFile], _Geometry]] = {
    'box': _box, 'cylinder': _cylinder, 'sphere': _sphere, 'plane': _plane, 'mesh': _mesh,
    'polyline': _polyline, 'heightmap': heightmaps.shape}
