"""Versions of SDF: what older and newer ones write in another way is made one form."""
import contextlib
import re
import xml.etree.ElementTree as ElementTree
from typing import Tuple

import numpy as np

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats import noises
from img_recog.formats.reader import is_true, read, words

Version = Tuple[int, ...]       # of the SDF format, like (1, 6)
_VERSION = re.compile('[0-9]{1,9}([.][0-9]{1,9})*')


def version_of(element: ElementTree.Element) -> Version:
    """Return the version of SDF that an element states, (0,) if it states none."""
    text = element.get('version', '').strip()
    return tuple(map(int, text.split('.'))) if _VERSION.fullmatch(text) else (0,)


def unify(root: ElementTree.Element) -> None:
    """Write what is in an <sdf> in the form that all versions share here.

    Each <pose> as `pose_of` reads it; its attributes are since 1.9. The noise of inertial units
    for each axis; until 1.5 it could be one for all.
    """
    if version_of(root) >= (1, 9):
        _use_radians(root)
    if root.tag == 'sdf' and version_of(root) < (1, 6):
        for imu in root.iter('imu'):
            noises.use_axes(imu)


def _use_radians(root: ElementTree.Element) -> None:
    for element in root.iter('pose'):
        angles, is_quaternion = (element.text or '').split(), (
            element.get('rotation_format') == 'quat_xyzw')
        if not element.get('degrees') and not is_quaternion:
            element.attrib.pop('rotation_format', None)
            continue
        with contextlib.suppress(SimulationError):      # `pose_of` says so
            values = read('7lengths' if is_quaternion else '6lengths', ' '.join(angles), '')
            if is_quaternion:
                turn = rotations.to_rpy(rotations.matrix(values[3:] / np.linalg.norm(values[3:])))
            else:
                is_degrees = is_true(element.get('degrees'))
                turn = np.radians(values[3:]) if is_degrees else values[3:]
            element.text = words((*values[:3], *turn))
        for name in ('degrees', 'rotation_format'):
            element.attrib.pop(name, None)
