"""The visuals of a URDF: what there is to draw of its links."""
import collections
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, Optional

from img_recog.simulation.descriptions import link_materials, sdf_shapes, urdf_shapes
from img_recog.simulation.descriptions.description import origin_of
from img_recog.simulation.descriptions.numbers import read_numbers
from img_recog.visuals import MESH, PLANE, Material, Shape, Visual


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
            yield _visual(element, numbers[link.get('name', '')], named)


def _visual(element: ElementTree.Element, part: int,
            named: Dict[Optional[str], ElementTree.Element]) -> Visual:
    shape, given = urdf_shapes.read(element), element.find('material')
    pose = origin_of(element).matrix()
    box = element.find('geometry/box')
    if box is not None and box.get(sdf_shapes.PLANE):
        x, y, z = shape.size
        shape, pose[:3, 3] = Shape(PLANE, (x, y)), pose[:3, 3] + pose[:3, 2] * z / 2
    return Visual(part, shape, pose, _material(element, named),
                  shape.kind == MESH and given is not None
                  and given.get(link_materials.REPLACES) is None)


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
        'rgba of material ' + element.get('name', ''),
        '1 1 1 1' if color is None else color.get('rgba'), 4).tolist()
    path = '' if texture is None else texture.get('filename', '')
    return None if color is None and not path else Material((red, green, blue, opacity), path)
