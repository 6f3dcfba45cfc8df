"""What is in a link of an SDF, as elements of a URDF: mass, friction and shapes."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Tuple

import numpy as np

from img_recog.files import FindFile
from img_recog.mesh_file import READABLE
from img_recog.simulation.descriptions import (generated_meshes, heightmaps, inertias,
                                               materials)
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import (read_direction, read_lengths,
                                                       read_number, words)
from img_recog.simulation.descriptions.sdf_frames import pose_of
from img_recog.simulation.descriptions.texts import name_of, text_of
from img_recog.simulation.descriptions.urdf_elements import (
    INERTIA_KEYS, check_mass, set_friction, set_inertial, set_origin)
from img_recog.simulation.descriptions.urdf_visuals import (CENTERED, IS_PLANE, OPACITY, SUBMESH,
                                                            material_element)
from img_recog.simulation.settings import SimulationError
from img_recog.visuals import GREY, Material

_PLANE_THICKNESS_M = 0.01       # below the plane

_Geometry = Tuple[ElementTree.Element, Transform]


def add_inertial(link: ElementTree.Element, source: ElementTree.Element,
                 offset: Transform) -> str:
    """Add the inertia of an SDF's link; return a warning, '' if it can be simulated as it is.

    offset: of the link in the frame of the URDF's link.
    """
    name = name_of(source)
    given = source.find('inertial')
    if given is None:
        given = ElementTree.Element('inertial')
    mass = read_number('<mass> of link ' + name, given.findtext('mass', '1'))
    check_mass('<mass> of link ' + name, mass)
    matrix = np.array([read_number(
        '<{}> of link {}'.format(key, name),
        given.findtext('inertia/' + key, '1' if key[1] == key[2] else '0'))
        for key in INERTIA_KEYS]).reshape(3, 3)
    possible = inertias.possible('link ' + name, mass, matrix)
    set_inertial(link, mass, offset @ pose_of(given), possible.matrix)
    return possible.warning


def add_friction(link: ElementTree.Element, source: ElementTree.Element) -> None:
    """Add the coefficient of the first collision that has one: PyBullet has one for each link.

    In Gazebo a negative one means as much as there can be, which is that of a link without one.
    """
    text = source.findtext('collision/surface/friction/ode/mu')
    if text is not None:
        value = read_number('<mu> of link ' + name_of(source), text)
        if value >= 0:
            set_friction(link, value)


def add_shape(link: ElementTree.Element, shape: ElementTree.Element, pose: Transform,
              find: FindFile, concave: bool) -> str:
    """Add an SDF <visual> or <collision> to the <link> of a URDF; return what its material
    lacks or ''.

    pose: of the shape in the link's frame. find: returns the path of the file or folder at a URI.
    concave: whether a collision mesh is not replaced by its convex hull.
    Raises SimulationError when it cannot be had, or a number is wrong.
    """
    geometry, offset = _geometry(shape, find)
    added = ElementTree.SubElement(link, shape.tag, name=name_of(shape))
    set_origin(added, pose @ offset)
    ElementTree.SubElement(added, 'geometry').append(geometry)
    if shape.tag == 'collision':
        if concave and geometry.tag == 'mesh':
            added.set('concave', 'yes')
        return ''
    material, missing = materials.of_sdf(shape, find)
    opacity = materials.opacity(shape)
    heightmap = shape.find('geometry/' + heightmaps.TAG)
    if material is None and heightmap is not None:
        material = heightmaps.material(heightmap, find)
    if geometry.tag == 'mesh' and material is None:
        added.set(OPACITY, repr(opacity))       # the file has materials
        return missing
    added.append(material_element(material or Material((*GREY[:3], opacity))))
    return missing


def is_terrain(shape: ElementTree.Element) -> bool:
    """Return whether a shape is a heightmap that carries: that is a body of its own."""
    return shape.tag == 'collision' and shape.find('geometry/' + heightmaps.TAG) is not None


def add_terrain(link: ElementTree.Element, shape: ElementTree.Element, find: FindFile
                ) -> Transform:
    """Add a heightmap to the <link> of a URDF.

    Returns the pose, in the frame of the shape, that PyBullet gives the middle of its heights.
    Raises SimulationError when it cannot be had, or a number is wrong.
    """
    name = '{} {}'.format(shape.tag, name_of(shape))
    element, pose = heightmaps.urdf_element(name, shape.findall('geometry/*')[0], find)
    added = ElementTree.SubElement(link, shape.tag, name=name_of(shape))
    ElementTree.SubElement(added, 'geometry').append(element)
    return pose @ IDENTITY._replace(
        translation=np.array((0.0, 0.0, heightmaps.read(element).middle)))


def _geometry(shape: ElementTree.Element, find: FindFile) -> _Geometry:
    """Return the element in a URDF's <geometry>, and its pose in the frame of the shape."""
    name, geometry = '{} {}'.format(shape.tag, name_of(shape)), shape.find('geometry')
    if geometry is None or not len(geometry):
        raise SimulationError('<{}> has no geometry'.format(name))
    element = geometry[0]
    make = _MAKERS.get(element.tag)
    if make is None:
        raise SimulationError('<{}> of {}'.format(element.tag, name))
    return make(name, element, find)


def _size(name: str, element: ElementTree.Element, tag: str, count: int) -> np.ndarray:
    values = read_lengths('<{}> of {}'.format(tag, name), element.findtext(tag), count)
    if np.any(values <= 0):
        raise SimulationError('<{}> of {}: got {!r}, expected more than 0'.format(
            tag, name, element.findtext(tag)))
    return values


def _box(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    return (ElementTree.Element('box', size=words(_size(name, element, 'size', 3))),
            IDENTITY)


def _cylinder(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    (radius,), (length,) = (_size(name, element, tag, 1) for tag in ('radius', 'length'))
    return (ElementTree.Element('cylinder', radius=repr(float(radius)),
                                length=repr(float(length))),
            IDENTITY)


def _sphere(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    (radius,) = _size(name, element, 'radius', 1)
    return (ElementTree.Element('sphere', radius=repr(float(radius))),
            IDENTITY)


def _plane(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    """Return a thin box, whose upper side is the plane."""
    normal = read_direction('<normal> of ' + name, element.findtext('normal', '0 0 1'))
    size = [1.0, 1.0]
    if element.find('size') is not None:
        size = _size(name, element, 'size', 2).tolist()
    rotation = _turn_z_to(normal / np.linalg.norm(normal))
    box = ElementTree.Element(
        'box', {'size': words((*size, _PLANE_THICKNESS_M)), IS_PLANE: 'true'})
    return (box, Transform(rotation, rotation @ (0, 0, -_PLANE_THICKNESS_M / 2)))


def _turn_z_to(direction: np.ndarray) -> np.ndarray:
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
        raise SimulationError('mesh ' + uri)
    if not path.lower().endswith(READABLE):
        raise SimulationError('mesh {} ({} are read)'.format(uri, ', '.join(READABLE)))
    scale = read_lengths('<scale> of ' + name, element.findtext('scale', '1 1 1'), 3)
    mesh = ElementTree.Element('mesh', filename=os.path.abspath(path), scale=words(scale))
    submesh = text_of(element, 'submesh/name')
    if submesh:
        mesh.set(SUBMESH, submesh)
        if text_of(element, 'submesh/center').lower() in ('1', 'true'):
            mesh.set(CENTERED, 'true')
    return mesh, IDENTITY


def _polyline(name: str, element: ElementTree.Element, _: FindFile) -> _Geometry:
    corners = [read_lengths('<point> of ' + name, point.text, 2).tolist()
               for point in element.findall('point')]
    (height,) = _size(name, element, 'height', 1)
    return _mesh_element(generated_meshes.extruded(corners, float(height))), IDENTITY


def _heightmap(name: str, element: ElementTree.Element, find: FindFile) -> _Geometry:
    """Return the mesh that is drawn; see `add_terrain` for what carries."""
    heightmap, pose = heightmaps.urdf_element(name, element, find)
    return _mesh_element(heightmaps.write_mesh(heightmap)), pose


def _mesh_element(path: str) -> ElementTree.Element:
    return ElementTree.Element('mesh', filename=path, scale='1 1 1')


_MAKERS: Dict[str, Callable[[str, ElementTree.Element, FindFile], _Geometry]] = {
    'box': _box, 'cylinder': _cylinder, 'sphere': _sphere, 'plane': _plane, 'mesh': _mesh,
    'polyline': _polyline, heightmaps.TAG: _heightmap}
