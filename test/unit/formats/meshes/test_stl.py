"""STL files, binary or of text, of the kinds that Gazebo reads."""
import struct

import numpy as np
import pytest

from img_recog.formats.meshes import mesh_file

FACET = ('facet normal 0 0 1\n outer loop\n  vertex 0 0 {0}\n  vertex 1.5e+00 0 {0}\n'
         '  vertex 0 1 {0}\n endloop\nendfacet\n')
SOLID = 'solid {}\n' + FACET.format(0) + FACET.format(2) + 'endsolid {}\n'
BINARY = struct.pack('<I', 2) + b''.join(
    struct.pack('<12f', 0, 0, 1, 0, 0, z, 1.5, 0, z, 0, 1, z) + bytes(2) for z in (0, 2))


@pytest.mark.parametrize('content, count', [
    (SOLID.format('', ''), 2), (SOLID.format('a', 'a') + SOLID.format('b', 'b'), 4),
    (SOLID.format('endsolid vertex 1 normal', 'my solid'), 2),
    (SOLID.format('a', 'a').replace('endsolid a\n', ''), 2),
    (SOLID.format('a', 'a').upper(), 2), (SOLID.format('a', 'a').replace('\n', '\r\n'), 2),
    (SOLID.format('a', 'a').replace('\n', '\r'), 2),
    ('\n# made by hand\n' + SOLID.format('a', 'a'), 2), (FACET.format(0), 1),
    (SOLID.format('caf\xe9', '').encode('latin-1'), 2),
    (bytes(80) + BINARY, 2), (b'solid a'.ljust(80) + BINARY, 2),
    (b'solid facet\nfacet\n'.ljust(80) + BINARY, 2), (bytes(80) + BINARY + b'more', 2)])
def test_all_facets_are_read(tmp_path, content, count):
    (tmp_path / 'a.STL').write_bytes(content if isinstance(content, bytes) else content.encode())
    positions = np.concatenate([part.positions for part in mesh_file.read(
        str(tmp_path / 'a.STL'))])
    assert positions.shape == (count, 3, 3)
    assert positions.reshape(-1, 3).min(axis=0).tolist() == [0, 0, 0]
    assert positions.reshape(-1, 3).max(axis=0).tolist() == [1.5, 1, 2 if count > 1 else 0]
