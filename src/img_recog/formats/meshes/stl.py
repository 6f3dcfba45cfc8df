"""STL files of either kind in the form that trimesh reads whole: binary ones of exact length."""
import re

import numpy as np

_HEADER, _COUNT, _FACET = 80, 4, 50         # bytes; the facets follow their count
_CORNER = re.compile(rb'^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)', re.M | re.I)
_IS_ASCII = re.compile(rb'\A\s*(?:[#!$].*\s+)*(?:solid|facet|color)\b', re.I)
_FACETS = re.compile(rb'^[ \t]*facet\b', re.M | re.I)
_BINARY_FACET = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('color', '<u2')])


def simplified(content: bytes) -> bytes:
    """Return a binary STL with the facets of another one, binary or of text.

    Like in Gazebo, a text is not read as a whole: names and several solids do not matter, and it
    may end early. Raises ValueError for a facet that has not three corners.
    """
    start = _HEADER + _COUNT
    end = start + _FACET * int.from_bytes(content[_HEADER:start], 'little')
    lines = b''
    if len(content) != end and _IS_ASCII.match(content):
        lines = content.replace(b'\r', b'\n')
    count, corners = len(_FACETS.findall(lines)), _CORNER.findall(lines)
    if not count:       # what follows the facets does not matter
        return content[:end] if start < end <= len(content) else content
    if len(corners) != 3 * count:
        raise ValueError('it has {} corners in {} facets'.format(len(corners), count))
    facets = np.zeros(count, _BINARY_FACET)
    facets['corners'] = np.array(corners).astype(float).reshape(-1, 3, 3)
    return bytes(_HEADER) + count.to_bytes(_COUNT, 'little') + facets.tobytes()
