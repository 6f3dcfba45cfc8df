"""Friction in SDF, and in the tags of a URDF that are copied into one."""
import xml.etree.ElementTree as ElementTree
from typing import Callable, Optional

import numpy as np

from img_recog.formats.numbers import read_lengths, read_number
from img_recog.model import FLOOR_FRICTION, Friction

# of a negative coefficient, which in Gazebo means as much as there can be
_MOST = 100.0


def of_surface(collision: ElementTree.Element, link: str) -> Optional[Friction]:
    """Return the friction of a <collision> of a link, in the frame of the collision; None without.
    """
    ode = collision.find('surface/friction/ode')
    return None if ode is None else of_texts(ode.findtext, link, 'mu')


def of_texts(text_of: Callable[[str], Optional[str]], link: str, mu: str) -> Optional[Friction]:
    """Return the friction of elements, None if none of them is given.

    text_of: returns the text of an element, None without; mu: the element of the first
    coefficient. The other one, too, is 1 if it is not given.
    """
    first, second, along = text_of(mu), text_of('mu2'), text_of('fdir1')
    if first is second is along is None:
        return None
    direction = read_lengths('<fdir1> of link ' + link, along or '0 0 0', 3)
    return Friction(
        _coefficient('<{}> of link {}'.format(mu, link), first),
        _coefficient('<mu2> of link ' + link, second),
        tuple(direction.tolist()) if np.any(direction) else ())


def _coefficient(name: str, text: Optional[str]) -> float:
    if text is None:
        return FLOOR_FRICTION
    value = read_number(name, text)
    return value if value >= 0 else _MOST
