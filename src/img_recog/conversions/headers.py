"""Headers in messages whose type is known by its definition alone."""
import struct
from typing import Optional

import genpy

_SEQ_AND_STAMP = struct.Struct('<III')      # at the beginning of a serialized header
_HEADER_TYPES = ('Header header', 'std_msgs/Header header')


def stamp_in(data: bytes, type_name: str, definition: str) -> Optional[genpy.Time]:
    """Return the stamp in a serialized message, None if its type has no header as first field.

    >>> stamp_in(bytes([0] * 4 + [5, 0, 0, 0] * 2), 'my/Type', 'int8 NO=0\\nHeader header').secs
    5
    """
    lines = (line.split('#')[0].strip() for line in definition.splitlines())
    first = next((line for line in lines if line and '=' not in line), '')
    if type_name != 'std_msgs/Header' and ' '.join(first.split()) not in _HEADER_TYPES:
        return None
    return genpy.Time(*_SEQ_AND_STAMP.unpack_from(data)[1:])
