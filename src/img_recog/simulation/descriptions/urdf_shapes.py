"""The shapes of visuals and collisions of a URDF."""
import xml.etree.ElementTree as ElementTree
from typing import Optional, Tuple

from img_recog.simulation.descriptions.numbers import read_lengths
from img_recog.simulation.settings import SimulationError
from img_recog.visuals import BOX, CYLINDER, MESH, SPHERE, Shape

_SIZES = {'box': (('size', 3),), 'cylinder': (('radius', 1), ('length', 1)),
          'sphere': (('radius', 1),), 'capsule': (('radius', 1), ('length', 1))}
_KINDS = {'box': BOX, 'cylinder': CYLINDER, 'sphere': SPHERE}


def check(robot: ElementTree.Element) -> None:
    """Raise SimulationError naming the link unless all shapes of a <robot> can be used."""
    for link in robot.findall('link'):
        for element in link.findall('visual') + link.findall('collision'):
            if element.find('geometry/*') is None:
                continue
            try:
                if element.tag == 'visual':
                    read(element)
                else:
                    _sizes(element.findall('geometry/*')[0])
            except SimulationError as error:
                raise SimulationError('link {}, <{}>: {}'.format(
                    link.get('name', ''), element.tag, error.problem), error.advice)


def read(visual: ElementTree.Element) -> Shape:
    """Return the shape of a <visual>; SimulationError when it cannot be drawn."""
    geometry = visual.find('geometry')
    if geometry is None or not len(geometry):
        raise SimulationError('<visual {}> has no geometry'.format(visual.get('name', '')))
    element = geometry[0]
    sizes = _sizes(element)
    if element.tag == 'mesh':
        return Shape(MESH, sizes, element.get('filename', ''))
    if element.tag not in _KINDS:
        raise SimulationError('got the geometry {}, expected box, cylinder, sphere or mesh'.format(
            element.tag))
    return Shape(_KINDS[element.tag], sizes)


def _sizes(element: ElementTree.Element) -> Tuple[float, ...]:
    """Return the size of a box, cylinder, sphere or capsule, or the scale of a mesh."""
    values: Tuple[float, ...] = ()
    for name, count in _SIZES.get(element.tag, ()):
        values += _read('{} of {}'.format(name, element.tag), element.get(name), count)
    if any(value < 0 for value in values):
        raise SimulationError('size of {}: got {}, expected no negative number'.format(
            element.tag, ' '.join('{:g}'.format(value) for value in values)))
    if element.tag == 'mesh':
        values = _read('scale of mesh', element.get('scale', '1 1 1'), 3)
    return values


def _read(name: str, text: Optional[str], count: int) -> Tuple[float, ...]:
    return tuple(read_lengths(name, text, count).tolist())
