"""The visuals of a URDF, their shapes and materials; and what <gazebo> tags say of those."""
import collections
import os
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, Optional, Tuple

from img_recog.files import FindFile
from img_recog.simulation.descriptions import materials
from img_recog.simulation.descriptions.numbers import read_lengths, read_numbers, words
from img_recog.simulation.descriptions.texts import name_of, text_of
from img_recog.simulation.descriptions.urdf_elements import origin_of
from img_recog.simulation.settings import SimulationError
from img_recog.visuals import (BOX, CYLINDER, MESH, PLANE, SPHERE, Material, Shape, Submesh,
                               Visual)

_SIZES = {'box': (('size', 3),), 'cylinder': (('radius', 1), ('length', 1)),
          'sphere': (('radius', 1),), 'capsule': (('radius', 1), ('length', 1))}
_KINDS = {'box': BOX, 'cylinder': CYLINDER, 'sphere': SPHERE}
IS_PLANE = 'plane'      # the attribute of a box that is a plane, the upper side of it
# In a URDF, a <material> is that of a mesh whose file has none, like in RViz; Gazebo 11 ignores
# it. A material of an SDF or of a <gazebo> tag replaces that of the file; it has this attribute.
_REPLACES = 'replaces_file'
# attributes of a material of an SDF
_SCALE, _PATTERN, _CUTOUT = 'texture_scale', 'pattern', 'cutout'
SUBMESH, CENTERED = 'submesh', 'centered'       # attributes of a mesh of an SDF
OPACITY = 'opacity'     # the attribute of a visual by which that of its mesh file is multiplied


def check(urdf: str) -> None:
    """Raise SimulationError when a number in a visual of a URDF is wrong."""
    for _ in read(urdf, collections.defaultdict(int)):
        pass


def read(urdf: str, numbers: Dict[str, int]) -> Iterator[Visual]:
    """Yield the visuals of a URDF; numbers: of its links, by name.

    Raises SimulationError when a number in a visual is wrong.
    """
    robot = ElementTree.fromstring(urdf)
    named = {material.get('name'): material for material in robot.findall('material')}
    for link in robot.findall('link'):
        for element in link.findall('visual'):
            yield _visual(element, numbers[name_of(link)], named)


def _visual(element: ElementTree.Element, part: int,
            named: Dict[Optional[str], ElementTree.Element]) -> Visual:
    shape, given = read_shape(element), element.find('material')
    pose = origin_of(element).matrix()
    box = element.find('geometry/box')
    if box is not None and box.get(IS_PLANE):
        x, y, z = shape.size
        shape, pose[:3, 3] = Shape(PLANE, (x, y)), pose[:3, 3] + pose[:3, 2] * z / 2
    return Visual(part, shape, pose, _material(element, named), shape.kind == MESH
                  and given is not None and given.get(_REPLACES) is None,
                  float(element.get(OPACITY, '1')))


def _material(visual: ElementTree.Element,
              named: Dict[Optional[str], ElementTree.Element]) -> Optional[Material]:
    """Return the material of a visual, None if it has none."""
    element = visual.find('material')
    if element is None:
        return None
    if element.find('color') is None and element.find('texture') is None:
        element = named.get(element.get('name'), element)
    color, texture = element.find('color'), element.find('texture')
    red, green, blue, opacity = read_numbers(
        'rgba of material ' + name_of(element),
        '1 1 1 1' if color is None else color.get('rgba'), 4).tolist()
    path = '' if texture is None else texture.attrib['filename']
    if color is None and not path:
        return None
    width, height = element.get(_SCALE, '1 1').split()
    return Material((red, green, blue, opacity), path, (float(width), float(height)),
                    element.get(_PATTERN, ''), element.get(_CUTOUT) is not None)


def check_shapes(robot: ElementTree.Element) -> None:
    """Raise SimulationError naming the link unless all shapes of a <robot> can be used."""
    for link in robot.findall('link'):
        for element in link.findall('visual') + link.findall('collision'):
            if element.find('geometry/*') is None:
                continue
            try:
                if element.tag == 'visual':
                    read_shape(element)
                else:
                    _sizes(element.findall('geometry/*')[0])
            except SimulationError as error:
                raise SimulationError('link {}, <{}>: {}'.format(
                    name_of(link), element.tag, error.problem), error.advice)


def read_shape(visual: ElementTree.Element) -> Shape:
    """Return the shape of a <visual>; SimulationError when it cannot be drawn."""
    geometry = visual.find('geometry')
    if geometry is None or not len(geometry):
        raise SimulationError('<visual {}> has no geometry'.format(name_of(visual)))
    element = geometry[0]
    sizes = _sizes(element)
    if element.tag == 'mesh':
        return Shape(MESH, sizes, element.get('filename', ''), submesh_of(element))
    if element.tag not in _KINDS:
        raise SimulationError('got the geometry {}, expected box, cylinder, sphere or mesh'.format(
            element.tag))
    return Shape(_KINDS[element.tag], sizes)


def submesh_of(mesh: ElementTree.Element) -> Submesh:
    """Return which part of the file of a <mesh> is meant."""
    return Submesh(mesh.get(SUBMESH, ''), mesh.get(CENTERED) is not None)


def _sizes(element: ElementTree.Element) -> Tuple[float, ...]:
    """Return the size of a box, cylinder, sphere or capsule, or the scale of a mesh."""
    if element.tag == 'mesh':
        return tuple(read_lengths('scale of mesh', element.get('scale', '1 1 1'), 3).tolist())
    values = tuple(
        value for name, count in _SIZES.get(element.tag, ())
        for value in read_lengths('{} of {}'.format(name, element.tag), element.get(name),
                                  count).tolist())
    if any(value < 0 for value in values):
        raise SimulationError('size of {}: got {}, expected no negative number'.format(
            element.tag, ' '.join('{:g}'.format(value) for value in values)))
    return values


def apply_materials(robot: ElementTree.Element, find: FindFile) -> List[str]:
    """Write the materials of <gazebo reference="LINK"> into the visuals of their links.

    find: returns the path of the file or folder at a URI. Textures of the URDF get absolute paths.
    Returns what is not known or not found, by name; those visuals stay as they are.
    """
    missing = _resolve_textures(robot, find)
    links = {link.get('name'): link for link in robot.findall('link')}
    for tag in robot.findall('gazebo'):
        link = links.get(tag.get('reference'))
        if link is None:
            continue
        for shape in _materials(tag):
            material, gap = materials.of_sdf(shape, find)
            if gap or material is None:
                missing += [gap] if gap and gap not in missing else []
                continue
            for visual in link.findall('visual'):
                for old in visual.findall('material'):
                    visual.remove(old)
                visual.append(material_element(material))
    return missing


def _resolve_textures(robot: ElementTree.Element, find: FindFile) -> List[str]:
    missing: List[str] = []
    for parent in robot.iter('material'):
        for texture in parent.findall('texture'):
            uri = texture.get('filename', '')
            path = find(uri)
            if path is None:
                parent.remove(texture)
                missing += [] if 'texture ' + uri in missing else ['texture ' + uri]
            else:
                texture.set('filename', os.path.abspath(path))
    return missing


def material_element(material: Material) -> ElementTree.Element:
    """Return a URDF's <material>, which replaces that of a mesh file."""
    # a name for each: in a URDF, materials of one name are the same
    made = ElementTree.Element('material', {
        'name': ' '.join(map(str, material)), _REPLACES: 'true', _SCALE: words(material.scale),
        _PATTERN: material.pattern, **({_CUTOUT: 'true'} if material.is_cutout else {})})
    ElementTree.SubElement(made, 'color', rgba=words(material.color))
    if material.texture:
        ElementTree.SubElement(made, 'texture', filename=material.texture)
    return made


def _materials(tag: ElementTree.Element) -> List[ElementTree.Element]:
    """Return the materials of a <gazebo> tag, each as an SDF <visual>; the last one counts."""
    shapes = [shape for shape in tag.findall('visual') if shape.find('material') is not None]
    name = text_of(tag, 'material')
    if name:
        shape = ElementTree.Element('visual')
        script = ElementTree.SubElement(ElementTree.SubElement(shape, 'material'), 'script')
        ElementTree.SubElement(script, 'name').text = name
        shapes.append(shape)
    return shapes
