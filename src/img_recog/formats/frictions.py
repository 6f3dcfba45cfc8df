"""Surfaces in SDF, and in the tags of a URDF that are copied into one."""
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional

import numpy as np

from img_recog.formats.numbers import read_lengths, read_number
from img_recog.model import FLOOR_FRICTION, Contact, Friction

# of a negative coefficient, which in Gazebo means as much as there can be
_MOST = 100.0      # of any coefficient: the forces of larger ones are not computable
# the fields of a Contact, below <surface> and in a tag of a URDF
_CONTACTS = {'stiffness': ('contact/ode/kp', 'kp'), 'damping': ('contact/ode/kd', 'kd'),
             'fastest': ('contact/ode/max_vel', 'maxVel'),
             'slack': ('contact/ode/min_depth', 'minDepth'),
             'bounce': ('bounce/restitution_coefficient', '')}
_HARD_N_M = 1e10       # no body is so heavy that a softer contact would differ
_SHORT = 1e-3       # of a direction
# what little reaches: without a <threshold>, it is 100 km/s
_FAST_M_S = 10.0

TextOf = Callable[[str], Optional[str]]


def of_surface(collision: ElementTree.Element, link: str) -> Optional[Friction]:
    """Return the friction of a <collision> of a link, in the frame of the collision; None without.
    """
    ode = collision.find('surface/friction/ode')
    return None if ode is None else of_texts(ode.findtext, link, 'mu')


def of_texts(text_of: TextOf, link: str, mu: str) -> Optional[Friction]:
    """Return the friction of elements, None if none of them is given.

    text_of: returns the text of an element, None without; mu: the element of the first
    coefficient. The other one, too, is 1 if it is not given.
    """
    first, second, along = text_of(mu), text_of('mu2'), text_of('fdir1')
    if first is second is along is None:
        return None
    direction = read_lengths('<fdir1> of link ' + link, along or '0 0 0', 3)
    if 0 < np.abs(direction).max() < _SHORT:    # it would be lost when it is rounded
        direction /= np.abs(direction).max()
    return Friction(
        _coefficient('<{}> of link {}'.format(mu, link), first),
        _coefficient('<mu2> of link ' + link, second),
        tuple(direction.tolist()) if np.any(direction) else ())


def contact_of(collision: ElementTree.Element, link: str, text_of: TextOf) -> Contact:
    """Return how a <collision> of a link pushes out what touches it.

    text_of: of the tags of that link, which count more.
    """
    found: Dict[str, float] = {}
    for field, (path, tag) in _CONTACTS.items():
        text = (text_of(tag) if tag else None) or collision.findtext('surface/' + path)
        if text is not None:
            found[field] = max(0.0, read_number(
                '<{}> of link {}'.format(path.rpartition('/')[2], link), text))
    contact = Contact(**found)
    threshold = collision.findtext('surface/bounce/threshold')
    if threshold is None or read_number('<threshold> of link ' + link, threshold) > _FAST_M_S:
        contact = contact._replace(bounce=0.0)
    # all that is hard is one surface
    return contact if (contact.stiffness < _HARD_N_M or contact.slack or contact.throws
                       or contact.bounce) else Contact()


def _coefficient(name: str, text: Optional[str]) -> float:
    if text is None:
        return FLOOR_FRICTION
    value = read_number(name, text)
    return min(value, _MOST) if value >= 0 else _MOST
