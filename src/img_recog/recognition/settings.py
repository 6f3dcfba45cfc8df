"""Which colours are looked for, and what is done when one is seen."""
from dataclasses import dataclass
from typing import Tuple


@dataclass(frozen=True)
class ColorRange:
    """A box in HSV on OpenCV's 8-bit scale (H 0-180, S and V 0-255), bounds included."""

    name: str
    lower: Tuple[int, int, int]
    upper: Tuple[int, int, int]


@dataclass(frozen=True)
class ColorRule:
    """Drive at `linear_x` m/s while more than `area_limit_px` pixels lie inside `color`."""

    color: ColorRange
    area_limit_px: int
    linear_x: float


# The article's numbers, in the order in which it looks and commands.
BLUE = ColorRule(ColorRange('blue', (50, 100, 100), (150, 255, 255)), 1000, 10.0)
RED = ColorRule(ColorRange('red', (150, 100, 150), (180, 255, 255)), 1000, -10.0)
RULES = (BLUE, RED)
