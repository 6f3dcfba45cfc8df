"""The lights of an SDF, and what is around its world."""
import math
import xml.etree.ElementTree as ElementTree
from typing import Optional

from img_recog.errors import SimulationError
from img_recog.formats.reader import name_of, text_of, value
from img_recog.model import (DIRECTIONAL, EXP, EXP2, LINEAR, POINT, SPOT, Fog, Light,
                             Surroundings)
from img_recog.rotations import Transform

_KINDS = DIRECTIONAL, POINT, SPOT
_CONE = 'inner_angle', 'outer_angle', 'falloff'


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
