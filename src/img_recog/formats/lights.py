"""The lights of an SDF, and what is around its world."""
import math
import xml.etree.ElementTree as ElementTree
from typing import Optional

from img_recog.errors import SimulationError
from img_recog.formats.materials import color_of
from img_recog.formats.numbers import read_direction, read_limit
from img_recog.formats.texts import name_of, text_of
from img_recog.model import (DIRECTIONAL, EXP, EXP2, LINEAR, POINT, SPOT, Fog, Light, Rgb,
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
    default = Light(kind)

    def number(path: str, value: float) -> float:
        text = element.findtext(path)
        return value if text is None else read_limit(
            '<{}> of {}'.format(path.split('/')[-1], name), text)
    # as Gazebo limits them
    constant, linear, quadratic = (
        min(max(number('attenuation/' + tag, value), 0.0), largest) for tag, value, largest in zip(
            ('constant', 'linear', 'quadratic'), default.attenuation, (1.0, 1.0, math.inf)))
    direction = read_direction('<direction> of ' + name, element.findtext('direction', '0 0 -1'))
    x, y, z = direction.tolist()
    inner, outer, falloff = (number('spot/' + tag, 0.0) for tag in _CONE)
    return Light(kind, pose, _rgb(element, 'diffuse', default.diffuse),
                 _rgb(element, 'specular', default.specular), (x, y, z),
                 number('attenuation/range', default.reach), (constant, linear, quadratic),
                 (inner, outer, max(falloff, 0.0)))


def surroundings(scene: ElementTree.Element) -> Surroundings:
    """Return what a <scene> says; SimulationError when a number is wrong."""
    default = Surroundings()
    return Surroundings(_rgb(scene, 'ambient', default.ambient),
                        _rgb(scene, 'background', default.background),
                        scene.find('sky') is not None, _fog(scene))


def _fog(scene: ElementTree.Element) -> Optional[Fog]:
    kind = text_of(scene, 'fog/type')
    if kind not in (LINEAR, EXP, EXP2):
        return None
    default = Fog(kind)
    start, end, density = (
        read_limit('<{}> of fog'.format(tag), scene.findtext('fog/' + tag, repr(value)))
        for tag, value in (('start', default.start), ('end', default.end),
                           ('density', default.density)))
    return Fog(kind, _rgb(scene, 'fog/color', default.color), start, end, density)


def _rgb(element: ElementTree.Element, path: str, default: Rgb) -> Rgb:
    return (color_of(element, path) or default)[:3]
