"""STL files, binary or of text."""
import re

import numpy as np

_HEADER, _COUNT, _FACET = 80, 4, 50         # bytes; the facets follow their count
_CORNER = re.compile(rb'^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)', re.M | re.I)
_IS_ASCII = re.compile(rb'\A\s*(?:[#!$].*\s+)*(?:solid|facet|color)\b', re.I)
_FACETS = re.compile(rb'^[ \t]*facet\b', re.M | re.I)
_BINARY_FACET = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('color', '<u2')])


def read(content: bytes) -> np.ndarray:
    """Return the corners (n, 3, 3) of the facets of an STL.

    Like in Gazebo, a text is not read as a whole: names and several solids do not matter, and it
    may end early. Raises ValueError for a facet that has not three corners.
    """
    start = _HEADER + _COUNT
    count = int.from_bytes(content[_HEADER:start], 'little')
    end = start + _FACET * count
    if len(content) != end and _IS_ASCII.match(content):
        lines = content.replace(b'\r', b'\n')
        facets, corners = len(_FACETS.findall(lines)), _CORNER.findall(lines)
        if facets:
            if len(corners) != 3 * facets:
                raise ValueError('it has {} corners in {} facets'.format(len(corners), facets))
            return np.array(corners).astype(float).reshape(-1, 3, 3)
    if end > len(content):      # what follows the facets does not matter
        raise ValueError('it has {} bytes, {} facets need {}'.format(len(content), count, end))
    return np.frombuffer(content, _BINARY_FACET, count, start)['corners'].astype(float)


def written(positions: np.ndarray) -> bytes:
    """Return a binary STL with these corners (n, 3, 3)."""
    facets = np.zeros(len(positions), _BINARY_FACET)
    facets['corners'] = positions
    return bytes(_HEADER) + len(facets).to_bytes(_COUNT, 'little') + facets.tobytes()
