"""Lenses of cameras: where in an image a direction is seen.

They are plain values, which the simulation gives, and with which rendering/ draws.
"""
import math
from typing import Any, Callable, Dict, NamedTuple, Tuple, Union

import numpy as np

TAN, SIN, ID = 'tan', 'sin', 'id'
FUNCTIONS = (TAN, SIN, ID)
CUSTOM = 'custom'
# c1, c2 and function of <lens><type> in SDF; c3 is 0 and f is 1
_TYPES: Dict[str, Tuple[float, float, str]] = {
    'gnomonical': (1.0, 1.0, TAN), 'stereographic': (2.0, 2.0, TAN), 'equidistant': (1.0, 1.0, ID),
    'equisolid_angle': (2.0, 2.0, SIN), 'orthographic': (1.0, 1.0, SIN)}
TYPES = (*_TYPES, CUSTOM)
_Function = Callable[[Any], np.ndarray]
_APPLY: Dict[str, _Function] = {TAN: np.tan, SIN: np.sin, ID: np.asarray}
_INVERT: Dict[str, _Function] = {TAN: np.arctan, SIN: np.arcsin, ID: np.asarray}


class Lens(NamedTuple):
    """A lens that bends all around its axis equally, like <lens> in SDF.

    A direction at an angle (rad) to the optical axis is seen at scale * function(angle / divisor
    + offset) from the middle of the image, in halves of its width. cutoff_angle: rad; what is
    seen at a larger angle is black. texture_size: of the side of a square picture of 90 degrees
    in px, than which nothing is drawn sharper.
    """

    scale: float
    divisor: float = 1.0
    offset: float = 0.0
    function: str = ID
    cutoff_angle: float = math.pi
    texture_size: int = 256

    def radius(self, angle: np.ndarray) -> np.ndarray:
        """Return how far from the middle of the image an angle is seen, in halves of its width.

        >>> round(float(Lens(2.0, 2.0, function=TAN).radius(math.pi / 2)), 6)
        2.0
        """
        return self.scale * _APPLY[self.function](np.asarray(angle) / self.divisor + self.offset)

    def angle(self, radius: np.ndarray) -> np.ndarray:
        """Return the angle that is seen there; NaN for none, which is black too."""
        with np.errstate(invalid='ignore'):
            angle = self.divisor * (_INVERT[self.function](np.asarray(radius) / self.scale)
                                    - self.offset)
            return np.where((angle < 0) | (angle > min(self.cutoff_angle, math.pi)), np.nan, angle)


class Distortion(NamedTuple):
    """The distortion of a pinhole camera by D of plumb_bob (sensor_msgs/CameraInfo)."""

    k1: float
    k2: float
    p1: float
    p2: float
    k3: float


AnyLens = Union[Lens, Distortion]


def scaled_to(lens: Lens, horizontal_fov: float) -> Lens:
    """Return the lens whose images are `horizontal_fov` (rad) wide, from edge to edge.

    Raises ValueError if there is none: the function is not positive there.

    >>> scaled_to(Lens(7.0), math.pi).scale * math.pi / 2
    1.0
    """
    at_edge = horizontal_fov / 2 / lens.divisor + lens.offset
    value = float(_APPLY[lens.function](at_edge))
    if value <= 1e-3 or (lens.function == TAN and at_edge >= math.pi / 2):
        raise ValueError('nothing is seen there')
    return lens._replace(scale=1 / value)


def of_type(kind: str) -> Lens:
    """Return a lens of one of TYPES but CUSTOM.

    >>> of_type('equisolid_angle').scale, of_type('equisolid_angle').function
    (2.0, 'sin')
    """
    c1, c2, function = _TYPES[kind]
    return Lens(c1, c2, 0.0, function)
