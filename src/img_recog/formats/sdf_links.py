"""What is in a link of an SDF: its mass and its shapes."""
import math
import os
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional, Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.files import FindFile, no_file
from img_recog.formats import generated_meshes, heightmaps, lumping, materials
from img_recog.formats.meshes.mesh_file import READABLE
from img_recog.formats.reader import (kind_of, name_of, read, required, text_of, value,
                                      values)
from img_recog.formats.sdf_frames import pose_of
from img_recog.model import (BOX, CYLINDER, DIRECTIONAL, EXP, EXP2, FLOOR_FRICTION, HEIGHTMAP,
                             LINEAR, MESH, PLANE, POINT, SPHERE, SPOT, WHITE, Contact, Fog,
                             Friction, Inertia, Light, Look, Shape, Solid, Submesh, Surroundings)
from img_recog.report import Report
from img_recog.rotations import IDENTITY, Transform

_KINDS = DIRECTIONAL, POINT, SPOT
_CONE = 'inner_angle', 'outer_angle', 'falloff'
# the fields of a Contact, in a <collision> and in a tag of a URDF
_CONTACTS = {'stiffness': ('surface/contact/ode/kp', 'kp'),
             'damping': ('surface/contact/ode/kd', 'kd'),
             'fastest': ('surface/contact/ode/max_vel', 'maxVel'),
             'slack': ('surface/contact/ode/min_depth', 'minDepth'),
             'bounce': ('surface/bounce/restitution_coefficient', '')}
_FRICTION = 'surface/friction/ode'
_HARD_N_M = 1e10       # no body is so heavy that a softer contact would differ
_SHORT = 1e-3       # of a direction
# what little reaches: without a <threshold>, it is 100 km/s
_FAST_M_S = 10.0

TextOf = Callable[[str], Optional[str]]
_Geometry = Tuple[Shape, Transform]


def light(element: ElementTree.Element, pose: Transform) -> Light:
    """Return a <light>; pose: in the world, or in the link that it belongs to.

    Raises SimulationError when its type is not known, or a number is wrong.
    """
    name = 'light {}'.format(name_of(element)).strip()
    kind = element.get('type', POINT)
    if kind not in _KINDS:
        raise SimulationError('{} of type {!r}, expected {}'.format(name, kind, ', '.join(_KINDS)))
    # as Gazebo limits them
    constant, linear, quadratic = (
        min(max(value(element, 'attenuation/' + tag), 0.0), largest) for tag, largest in (
            ('constant', 1.0), ('linear', 1.0), ('quadratic', math.inf)))
    x, y, z = value(element, 'direction').tolist()
    inner, outer, falloff = (value(element, 'spot/' + tag) for tag in _CONE)
    return Light(kind, pose, value(element, 'diffuse')[:3], value(element, 'specular')[:3],
                 (x, y, z), value(element, 'attenuation/range'), (constant, linear, quadratic),
                 (inner, outer, max(falloff, 0.0)))


def surroundings(scene: ElementTree.Element) -> Surroundings:
    """Return what a <scene> says; SimulationError when a number is wrong."""
    return Surroundings(value(scene, 'ambient')[:3], value(scene, 'background')[:3],
                        scene.find('sky') is not None, _fog(scene))


def _fog(scene: ElementTree.Element) -> Optional[Fog]:
    kind = text_of(scene, 'fog/type')
    if kind not in (LINEAR, EXP, EXP2):
        return None
    return Fog(kind, value(scene, 'fog/color')[:3], *(
        value(scene, 'fog/' + tag) for tag in ('start', 'end', 'density')))


def friction_of(collision: ElementTree.Element, link: str) -> Optional[Friction]:
    """Return the friction of a <collision> of a link, in the frame of the collision; None without.
    """
    ode = collision.find(_FRICTION)
    return None if ode is None else friction_of_texts(ode.findtext, link, 'mu')


def friction_of_texts(text_at: TextOf, link: str, mu: str) -> Optional[Friction]:
    """Return the friction of elements, None if none of them is given.

    text_at: returns the text of an element, None without; mu: the element of the first
    coefficient. The other one, too, is 1 if it is not given.
    """
    first, second, along = text_at(mu), text_at('mu2'), text_at('fdir1')
    if first is second is along is None:
        return None
    direction = read(kind_of('collision', _FRICTION + '/fdir1'), along or '0 0 0',
                     '<fdir1> of link ' + link)
    if 0 < np.abs(direction).max() < _SHORT:    # it would be lost when it is rounded
        direction /= np.abs(direction).max()
    one, other = (
        FLOOR_FRICTION if text is None else read(kind_of('collision', _FRICTION + '/mu'), text,
                                                 '<{}> of link {}'.format(tag, link))
        for tag, text in ((mu, first), ('mu2', second)))
    return Friction(one, other, tuple(direction.tolist()) if np.any(direction) else ())


def contact_of(collision: ElementTree.Element, link: str, text_at: TextOf) -> Contact:
    """Return how a <collision> of a link pushes out what touches it.

    text_at: of the tags of that link, which count more.
    """
    found: Dict[str, float] = {}
    for field, (path, tag) in _CONTACTS.items():
        text = (text_at(tag) if tag else None) or collision.findtext(path)
        if text is not None:
            found[field] = read(kind_of('collision', path), text,
                                '<{}> of link {}'.format(path.rpartition('/')[2], link))
    contact = Contact(**found)
    threshold = value(collision, 'surface/bounce/threshold', 'link ' + link)
    if threshold is None or threshold > _FAST_M_S:
        contact = contact._replace(bounce=0.0)
    # all that is hard is one surface
    return contact if (contact.stiffness < _HARD_N_M or contact.slack or contact.throws
                       or contact.bounce) else Contact()


def inertia(link: ElementTree.Element, offset: Transform, report: Report) -> Inertia:
    """Return the inertia of a link.

    offset: of the link in the frame in which the inertia is returned. report: gets a finding if it
    cannot be simulated as it is.
    """
    name, mass, given = name_of(link), value(link, 'inertial/mass'), link.find('inertial')
    lumping.check_mass('<mass> of link ' + name, mass)
    matrix = np.array([value(link, 'inertial/inertia/' + key)
                       for key in lumping.INERTIA_KEYS]).reshape(3, 3)
    return Inertia(mass, offset if given is None else offset @ pose_of(given),
                   lumping.possible_inertia('link ' + name, mass, matrix, report))


def decay(link: ElementTree.Element) -> Tuple[float, float]:
    """Return the shares of its velocities that a link loses in each step, see Link."""
    return value(link, 'velocity_decay/linear'), value(link, 'velocity_decay/angular')


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
    if value(collision, 'surface/contact/collide_without_contact'):
        return 0
    return value(collision, 'surface/contact/collide_bitmask')


def look(visual: ElementTree.Element, pose: Transform, find: FindFile, report: Report) -> Look:
    """Return a <visual>; arguments and errors as for `solid`.

    report: gets a finding if its material is not found.
    """
    shape, offset = _geometry(visual, find)
    material = materials.of_sdf(visual, find, report)
    opacity = materials.opacity(visual)
    if shape.kind == HEIGHTMAP:
        if material is None:
            opacity = 1.0       # terrain without a material is never transparent
            material = heightmaps.material(visual.findall('geometry/*')[0], find)
        shape = Shape(MESH, (1.0, 1.0, 1.0), heightmaps.write_mesh(shape))
    if material is None and shape.kind == MESH:         # the file has materials
        return Look(shape, pose @ offset, opacity=opacity)
    return Look(shape, pose @ offset, (material or WHITE).faded(opacity))


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


def _box(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(BOX, tuple(required(element, 'size', name).tolist())), IDENTITY


def _cylinder(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(CYLINDER, (required(element, 'radius', name),
                            required(element, 'length', name))), IDENTITY


def _sphere(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return Shape(SPHERE, (required(element, 'radius', name),)), IDENTITY


def _plane(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    direction = value(element, 'normal', name)
    return Shape(PLANE, tuple(value(element, 'size', name).tolist())), IDENTITY._replace(
        rotation=turn_z_to(direction / np.linalg.norm(direction)))


def normal(collision: ElementTree.Element) -> Optional[np.ndarray]:
    """Return the normal (3,) of a <collision> that is a plane, as it is given; None of others."""
    if collision.find('geometry/plane') is None:
        return None
    return value(collision, 'geometry/plane/normal')


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
    submesh = text_of(element, 'submesh/name')
    return Shape(MESH, tuple(value(element, 'scale', name).tolist()), os.path.abspath(path),
                 Submesh(submesh, bool(submesh) and value(element, 'submesh/center'))), IDENTITY


def _polyline(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    """Return the prism of all <polyline>s in a <geometry>; the height of the first counts."""
    outlines = [[point.tolist() for point in values(polyline, 'point', name)]
                for polyline in element.findall('polyline')]
    height = required(element[0], 'height', name)
    return Shape(MESH, (1.0, 1.0, 1.0), generated_meshes.extruded(outlines, height)), IDENTITY


_MAKERS: Dict[str, Callable[[str, ElementTree.Element, FindFile], _Geometry]] = {
    'box': _box, 'cylinder': _cylinder, 'sphere': _sphere, 'plane': _plane, 'mesh': _mesh,
    'polyline': _polyline, 'heightmap': heightmaps.shape}
