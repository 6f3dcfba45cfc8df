"""The materials that <gazebo> tags of a URDF give to links, written into the links' visuals."""
import copy
import os
import xml.etree.ElementTree as ElementTree
from typing import List

from img_recog.files import FindFile
from img_recog.simulation.descriptions import materials
from img_recog.visuals import Material

# In a URDF, a <material> is that of a mesh whose file has none, like in RViz; Gazebo 11 ignores
# it. A material of an SDF or of a <gazebo> tag replaces that of the file; it has this attribute.
REPLACES = 'replaces_file'


def apply(robot: ElementTree.Element, find: FindFile) -> List[str]:
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
        for shape in _shapes(tag):
            material, gap = materials.of_sdf(shape, find)
            if gap:
                missing += [gap] if gap not in missing else []
                continue
            for visual in link.findall('visual'):
                for old in visual.findall('material'):
                    visual.remove(old)
                visual.append(element(material))
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


def element(material: Material) -> ElementTree.Element:
    """Return a URDF's <material>, which replaces that of a mesh file."""
    # a name for each: in a URDF, materials of one name are the same
    made = ElementTree.Element('material', {'name': '{} {}'.format(*material), REPLACES: 'true'})
    ElementTree.SubElement(made, 'color', rgba=' '.join(repr(value) for value in material.color))
    if material.texture:
        ElementTree.SubElement(made, 'texture', filename=material.texture)
    return made


def _shapes(tag: ElementTree.Element) -> List[ElementTree.Element]:
    """Return the materials of a <gazebo> tag, each as an SDF <visual>; the last one counts."""
    shapes = [copy.deepcopy(shape) for shape in tag.findall('visual')
              if shape.find('material') is not None]
    name = tag.findtext('material', '').strip()
    if name:
        shape = ElementTree.Element('visual')
        script = ElementTree.SubElement(ElementTree.SubElement(shape, 'material'), 'script')
        ElementTree.SubElement(script, 'name').text = name
        shapes.append(shape)
    return shapes
