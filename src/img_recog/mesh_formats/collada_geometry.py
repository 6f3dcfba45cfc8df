"""The triangles of a <geometry> of a COLLADA file."""
import contextlib
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from img_recog.mesh_formats.collada_materials import read_floats
from img_recog.mesh_formats.polygons import fans

_DRAWN = 'triangles', 'polylist', 'polygons', 'tristrips', 'trifans'
_COMPONENTS = {'POSITION': 3, 'NORMAL': 3, 'TEXCOORD': 2}
# of what is damaged: it is left out
_ERRORS = (ArithmeticError, IndexError, KeyError, ValueError)
Arrays = Sequence[np.ndarray]       # positions, normals and uvs, as in FilePart


def count_triangles(geometry: ElementTree.Element) -> int:
    """Return how many triangles a <geometry> has; polygons are cut into triangles."""
    return sum(int(np.maximum(_sizes(each) - 2, 0).sum()) for each in geometry.iterfind('mesh/*')
               if each.tag in _DRAWN)


def _sizes(primitive: ElementTree.Element) -> np.ndarray:
    """Return how many corners each triangle, polygon, fan or strip has."""
    if primitive.tag == 'polylist':
        return np.array((primitive.findtext('vcount') or '').split(), int)
    width = _width(primitive)
    corners = [len((indices.text or '').split()) // width for indices in primitive.findall('p')]
    if primitive.tag == 'triangles':
        return np.full(sum(count // 3 for count in corners), 3)
    return np.array(corners, int)


def _width(primitive: ElementTree.Element) -> int:
    """Return how many indices there are for a corner."""
    return 1 + max([int(each.get('offset', '0')) for each in primitive.findall('input')] or [0])


def read(geometry: ElementTree.Element) -> Dict[str, Arrays]:
    """Return the triangles of a <geometry> by the symbols of their materials, '' without one.

    Of several sets of texture coordinates the first one counts, like in Gazebo.
    """
    found: Dict[str, List[Arrays]] = {}
    for mesh in geometry.findall('mesh'):
        sources = {each.get('id', ''): each for each in mesh.findall('source')}
        of_vertices = mesh.findall('vertices/input')
        for primitive in mesh:
            if primitive.tag in _DRAWN:
                with contextlib.suppress(*_ERRORS):
                    found.setdefault(primitive.get('material', ''), []).append(
                        _arrays(primitive, sources, of_vertices))
    return {symbol: [np.concatenate(each) for each in zip(*arrays)]
            for symbol, arrays in found.items() if arrays}


def _arrays(primitive: ElementTree.Element, sources: Dict[str, ElementTree.Element],
            of_vertices: Sequence[ElementTree.Element]) -> Arrays:
    """Return the corners of some triangles; raise one of _ERRORS if they are damaged."""
    columns: Dict[str, Tuple[int, np.ndarray]] = {}
    for each in primitive.findall('input'):
        offset = int(each.get('offset', '0'))
        inputs = of_vertices if each.get('semantic') == 'VERTEX' else [each]
        for semantic, name in ((one.get('semantic', ''), one.get('source', '').lstrip('#'))
                               for one in inputs):
            values = None
            if semantic in _COMPONENTS and semantic not in columns:
                values = _values(sources[name], _COMPONENTS[semantic])
            if values is not None:
                columns[semantic] = offset, values
    if 'POSITION' not in columns:
        raise ValueError('it has no positions')
    corners = _corners(primitive)
    if corners.min(initial=0) < 0:
        raise IndexError('an index is below 0')
    return [columns[semantic][1][corners[..., columns[semantic][0]]] if semantic in columns
            else np.zeros((len(corners), 3, count)) for semantic, count in _COMPONENTS.items()]


def _values(source: ElementTree.Element, components: int) -> Optional[np.ndarray]:
    """Return the values (n, components) of a <source>, None if it has none."""
    numbers = read_floats(source.findtext('float_array'))
    accessor = source.find('technique_common/accessor')
    if not len(numbers):
        return None
    stride = int(accessor.get('stride', components)) if accessor is not None else components
    start = int(accessor.get('offset', '0')) if accessor is not None else 0
    if stride < components:
        raise ValueError('a source has {} components, expected {}'.format(stride, components))
    count = (len(numbers) - start) // stride
    return numbers[start:start + count * stride].reshape(-1, stride)[:, :components]


def _corners(primitive: ElementTree.Element) -> np.ndarray:
    """Return the indices (n, 3, width) of the corners of triangles."""
    width = _width(primitive)
    tables = [np.array((indices.text or '').split(), int) for indices in primitive.findall('p')]
    tables = [table[:len(table) // width * width].reshape(-1, width) for table in tables]
    if primitive.tag == 'tristrips':
        return np.concatenate([_strip(table) for table in tables])
    if primitive.tag == 'triangles':
        tables = [table[:len(table) // 3 * 3] for table in tables]
    return np.concatenate(tables)[fans(_sizes(primitive))]


def _strip(table: np.ndarray) -> np.ndarray:
    """Return the corners (n, 3, width) of a strip, of which every second triangle is turned."""
    numbers = np.arange(max(len(table) - 2, 0))[:, None] + np.arange(3)
    numbers[1::2] = numbers[1::2, ::-1]
    return table[numbers]
