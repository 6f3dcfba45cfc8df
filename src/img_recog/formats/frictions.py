"""Surfaces in SDF, and in the tags of a URDF that are copied into one."""
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional

import numpy as np

from img_recog.formats.reader import read
from img_recog.model import FLOOR_FRICTION, Contact, Friction

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
    direction = read('3lengths', along or '0 0 0', '<fdir1> of link ' + link)
    if 0 < np.abs(direction).max() < _SHORT:    # it would be lost when it is rounded
        direction /= np.abs(direction).max()
    one, other = (
        FLOOR_FRICTION if text is None else read('friction', text,
                                                 '<{}> of link {}'.format(tag, link))
        for tag, text in ((mu, first), ('mu2', second)))
    return Friction(one, other, tuple(direction.tolist()) if np.any(direction) else ())


def contact_of(collision: ElementTree.Element, link: str, text_of: TextOf) -> Contact:
    """Return how a <collision> of a link pushes out what touches it.

    text_of: of the tags of that link, which count more.
    """
    found: Dict[str, float] = {}
    for field, (path, tag) in _CONTACTS.items():
        text = (text_of(tag) if tag else None) or collision.findtext('surface/' + path)
        if text is not None:
            found[field] = read('positive', text,
                                '<{}> of link {}'.format(path.rpartition('/')[2], link))
    contact = Contact(**found)
    threshold = collision.findtext('surface/bounce/threshold')
    if threshold is None or read('number', threshold, '<threshold> of link ' + link) > _FAST_M_S:
        contact = contact._replace(bounce=0.0)
    # all that is hard is one surface
    return contact if (contact.stiffness < _HARD_N_M or contact.slack or contact.throws
                       or contact.bounce) else Contact()
