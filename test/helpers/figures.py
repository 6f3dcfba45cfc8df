"""Pictures that are compared with those that are kept."""
import os

import cv2
import matplotlib
import numpy as np
import pytest

_RECORDED_WITH = '3.6.'
_SCALE = 0.5            # of what is kept
_TOLERANCE = 8          # of 255


def of_matplotlib(png: bytes) -> np.ndarray:
    """Return the BGR image in a PNG of matplotlib.

    Skips the test for another version of matplotlib: ticks and sizes of texts differ.
    """
    if not matplotlib.__version__.startswith(_RECORDED_WITH):
        pytest.skip('recorded with matplotlib {}x, this is {}'.format(
            _RECORDED_WITH, matplotlib.__version__))
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)


def assert_unchanged(picture: np.ndarray, path: str, folder, tolerance: int = _TOLERANCE) -> None:
    """Compare a BGR image with the one that is kept in a file; write what it is now to `folder`.

    By the largest difference: a marker that is one point longer changes the root mean square,
    which matplotlib's compare_images returns, by only 0.09 of 255.
    """
    new_path = os.path.join(str(folder), os.path.basename(path))
    new = cv2.resize(picture, None, fx=_SCALE, fy=_SCALE, interpolation=cv2.INTER_AREA)
    cv2.imwrite(new_path, new, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    kept, advice = cv2.imread(path), 'if this is wanted, copy {} to {}'.format(new_path, path)
    assert kept is not None and kept.shape == new.shape, advice
    assert np.abs(kept.astype(int) - new).max() <= tolerance, advice
