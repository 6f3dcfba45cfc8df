"""Patterns in place of the textures of Gazebo's own materials, which are not in this package."""
import functools
from typing import Callable, Dict, Sequence

import numpy as np

_SIZE_PX = 128
_SEED = 1
# of a pixel, to the right and upward, from 0 to 1; an array of brightnesses has this shape
_RIGHT, _UP = np.meshgrid((np.arange(_SIZE_PX) + 0.5) / _SIZE_PX,
                          1 - (np.arange(_SIZE_PX) + 0.5) / _SIZE_PX)


@functools.lru_cache(maxsize=None)
def image(pattern: str, color: Sequence[float]) -> np.ndarray:
    """Return the image of a pattern, RGB of shape (rows, columns, 3), with a mean color of 0 to 1.

    An unknown pattern is the plain color. Equal arguments give the same array.
    """
    brightness = _PATTERNS.get(pattern, np.ones_like)(_RIGHT)
    return np.round(np.clip(brightness[:, :, None] / brightness.mean() * color[:3], 0, 1)
                    * 255).astype(np.uint8)


def _edges(count: float, values: np.ndarray, width: float = 0.1) -> np.ndarray:
    """Return 1 at the edges of so many equal parts, else 0; width: of the edge, of a part."""
    return (np.abs(values * count - np.round(values * count)) < width / 2).astype(float)


def _spots(cells: int, contrast: float) -> np.ndarray:
    """Return random brightnesses of so many cells by cells, around 1."""
    values = np.random.RandomState(_SEED).uniform(1 - contrast, 1 + contrast, (cells, cells))
    return np.kron(values, np.ones((_SIZE_PX // cells, _SIZE_PX // cells)))


def _bricks(right: np.ndarray) -> np.ndarray:
    rows = np.floor(_UP * 8)
    joints = np.maximum(_edges(8, _UP, 0.2), _edges(4, right + rows % 2 / 8))
    return 1 + 0.5 * joints + _spots(8, 0.06) - 1


def _planks(right: np.ndarray) -> np.ndarray:
    rows = np.floor(_UP * 8)
    gaps = np.maximum(_edges(8, _UP), _edges(2, right + rows % 3 / 6, 0.02))
    return (1 - 0.5 * gaps) * (1 + 0.1 * np.sin(rows * 5)) + 0.04 * np.sin(_UP * 300)


def _wood(right: np.ndarray) -> np.ndarray:
    return 1 + 0.1 * np.sin(40 * right + 4 * np.sin(3 * _UP)) + 0.04 * np.sin(170 * right)


def _tiles(right: np.ndarray) -> np.ndarray:
    joints = np.maximum(_edges(4, right, 0.06), _edges(4, _UP, 0.06))
    return (1 - 0.4 * joints) * _spots(64, 0.05)


def _frame(right: np.ndarray) -> np.ndarray:
    return 1 - 0.5 * np.maximum(_edges(1, right, 0.15), _edges(1, _UP, 0.15))


def _lanes(count: int) -> Callable[[np.ndarray], np.ndarray]:
    def brightness(right: np.ndarray) -> np.ndarray:
        side = _edges(1, (right - 0.03) / 0.94, 0.02)
        dashed = _edges(count, right, 0.02 * count) * (_UP % 0.5 < 0.25)
        inner = dashed * (np.abs(right - 0.5) < 0.45)
        return (1 + 2 * np.maximum(side, inner)) * _spots(64, 0.1)
    return brightness


def _steps(right: np.ndarray) -> np.ndarray:
    return 0.7 + 0.6 * (_UP * 8 % 1) - 0 * right


def _quarters(right: np.ndarray) -> np.ndarray:
    return ((right < 0.5) == (_UP < 0.5)).astype(float)


_PATTERNS: Dict[str, Callable[[np.ndarray], np.ndarray]] = {
    'bricks': _bricks, 'planks': _planks, 'wood': _wood, 'tiles': _tiles, 'frame': _frame,
    'lane': _lanes(1), 'lanes 2': _lanes(2), 'lanes 4': _lanes(4), 'lanes 6': _lanes(6),
    'steps': _steps, 'quarters': _quarters, 'gradient': lambda right: 1.5 - _UP + 0 * right,
    'grass': lambda _: _spots(64, 0.3), 'plaster': lambda _: _spots(64, 0.03),
    'clouds': lambda right: 1 + 0.1 * np.sin(9 * right + 3 * np.sin(7 * _UP)) * np.cos(8 * _UP)}
