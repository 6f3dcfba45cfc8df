"""The friction of links, as Gazebo's tags and PyBullet's elements give it."""
import xml.etree.ElementTree as ElementTree
from typing import Dict

from img_recog.simulation.descriptions.numbers import read_coefficient
from img_recog.simulation.descriptions.texts import name_of

# Of the floor, and of links without a coefficient (Gazebo's default). PyBullet multiplies the
# coefficients of two bodies, Gazebo takes the lower one: a higher one makes no difference there.
FLOOR_FRICTION = 1.0
_MU = 'surface/friction/ode/mu'


def frictions(robot: ElementTree.Element) -> Dict[str, float]:
    """Return the friction of the links that have one, by their names.

    It is mu1 of Gazebo's tag for the link, or mu of a collision there, else PyBullet's
    lateral_friction.
    """
    found = {}
    of_tags = [(tag.get('reference'), element) for path in ('mu1', 'collision/' + _MU)
               for tag in robot.findall('gazebo') for element in tag.findall(path)]
    for link in robot.findall('link'):
        name = name_of(link)
        of_tag = next((each for reference, each in of_tags if reference == name), None)
        of_link = link.find('contact/lateral_friction')
        if of_tag is not None:
            found[name] = read_coefficient('{} of link {}'.format(of_tag.tag, name),
                                           of_tag.get('value') or of_tag.text)
        elif of_link is not None:
            found[name] = read_coefficient('lateral_friction of link ' + name,
                                           of_link.get('value'))
    return found


def of_surface(shape: ElementTree.Element, link: str) -> float:
    """Return the friction in the <surface> of a collision, which Gazebo reads only in an SDF.

    Robots whose casters need it have it there: they drive in Gazebo, whose solver loads the wheels
    more than PyBullet does.
    """
    text = shape.findtext(_MU)
    return FLOOR_FRICTION if text is None else read_coefficient(
        '<mu> of a collision of link ' + link, text)
