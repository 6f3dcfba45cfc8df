"""A <geometry> of a COLLADA file with nothing but what is drawn of it."""
import copy
import xml.etree.ElementTree as ElementTree
from typing import Dict, Optional, Tuple

import numpy as np

NO_MATERIAL = 'no material'     # the symbol of triangles that name none
_DRAWN = 'triangles', 'polylist', 'polygons', 'tristrips', 'trifans'
_COMPONENTS = {'POSITION': 'XYZ', 'NORMAL': 'XYZ', 'TEXCOORD': 'ST'}


def count_triangles(geometry: ElementTree.Element) -> int:
    """Return how many triangles a <geometry> has; polygons are cut into triangles."""
    return sum(_count(each) for each in geometry.iterfind('mesh/*') if each.tag in _DRAWN)


def _count(primitive: ElementTree.Element) -> int:
    width = _width(primitive)
    corners = [len((indices.text or '').split()) // width for indices in primitive.findall('p')]
    if primitive.tag == 'triangles':
        return sum(count // 3 for count in corners)
    if primitive.tag == 'polylist':
        sizes = np.array((primitive.findtext('vcount') or '').split(), int)
        return int(np.maximum(sizes - 2, 0).sum())
    return sum(max(count - 2, 0) for count in corners)


def _width(primitive: ElementTree.Element) -> int:
    """Return how many indices there are for a corner."""
    return 1 + max([int(each.get('offset', '0')) for each in primitive.findall('input')] or [0])


def simplify(geometry: ElementTree.Element) -> ElementTree.Element:
    """Remove from a <geometry> what is not drawn, of which some would make pycollada refuse it.

    All triangles get a material: NO_MATERIAL if they have none. Of several sets of texture
    coordinates the first one stays, like in Gazebo.
    """
    for mesh in geometry.findall('mesh'):
        sources = {each.get('id', ''): each for each in mesh.findall('source')}
        _share_normals(mesh, sources)
        used = _simplify_vertices(mesh, sources)
        for child in list(mesh):
            if child.tag in _DRAWN and _count(child):
                child.set('material', child.get('material') or NO_MATERIAL)
                used.update(_simplify_primitive(child, sources))
            elif child.tag not in ('source', 'vertices'):
                mesh.remove(child)
        for name, source in sources.items():
            if name in used:
                _set_components(source, _COMPONENTS[used[name]])
            else:
                mesh.remove(source)
    return geometry


def _share_normals(mesh: ElementTree.Element, sources: Dict[str, ElementTree.Element]) -> None:
    """Give all <vertices> at a place the first normal there, as ColladaLoader of Gazebo does.

    Triangles that have normals of their own do not use these.
    """
    for vertices in mesh.findall('vertices'):
        inputs = {each.get('semantic'): each for each in vertices.findall('input')}
        positions, normals = (sources.get(inputs[name].get('source', '').lstrip('#'))
                              if name in inputs else None for name in ('POSITION', 'NORMAL'))
        if positions is None or normals is None:
            continue
        normals = copy.deepcopy(normals)        # triangles may use them, too
        places, values = _values(positions), _values(normals)
        array = normals.find('float_array')
        if array is None or len(values) < len(places):
            continue
        first, numbers = np.unique(places, axis=0, return_index=True, return_inverse=True)[1:]
        array.text = ' '.join(map(repr, values[first[numbers.ravel()]].ravel().tolist()))
        name = normals.get('id', '') + ' of vertices'
        normals.set('id', name)
        inputs['NORMAL'].set('source', '#' + name)
        mesh.insert(0, normals)
        sources[name] = normals


def _values(source: ElementTree.Element) -> np.ndarray:
    """Return the values (n, 3) of a source."""
    _set_components(source, _COMPONENTS['NORMAL'])
    return np.array((source.findtext('float_array') or '').split(), float).reshape(-1, 3)


def _simplify_vertices(mesh: ElementTree.Element,
                       sources: Dict[str, ElementTree.Element]) -> Dict[str, str]:
    """Keep what is drawn of the inputs of <vertices>; return their sources and what these are."""
    used = {}
    for vertices in mesh.findall('vertices'):
        for each in vertices.findall('input'):
            semantic, name = each.get('semantic', ''), each.get('source', '').lstrip('#')
            if semantic in _COMPONENTS and not _is_empty(sources.get(name)):
                used[name] = semantic
            else:
                vertices.remove(each)
    return used


def _simplify_primitive(primitive: ElementTree.Element,
                        sources: Dict[str, ElementTree.Element]) -> Dict[str, str]:
    """Keep what is drawn of the inputs of triangles; return their sources and what these are."""
    width = _width(primitive)
    kept: Dict[str, Tuple[int, ElementTree.Element]] = {}
    for each in primitive.findall('input'):
        semantic, name = each.get('semantic', ''), each.get('source', '').lstrip('#')
        is_drawn = semantic == 'VERTEX' or (
            semantic in _COMPONENTS and not _is_empty(sources.get(name)))
        if is_drawn and semantic not in kept:
            kept[semantic] = int(each.get('offset', '0')), each
        else:
            primitive.remove(each)
    columns = sorted({offset for offset, _ in kept.values()})
    if len(columns) < width:
        for indices in primitive.findall('p'):
            table = np.array((indices.text or '').split()).reshape(-1, width)
            indices.text = ' '.join(table[:, columns].ravel().tolist())
    for offset, each in kept.values():
        each.set('offset', str(columns.index(offset)))
    return {each.get('source', '').lstrip('#'): semantic
            for semantic, (_, each) in kept.items() if semantic != 'VERTEX'}


def _is_empty(source: Optional[ElementTree.Element]) -> bool:
    return source is not None and not (source.findtext('float_array') or '').strip()


def _set_components(source: ElementTree.Element, names: str) -> None:
    """Give each value of a source the components of these names."""
    accessor = source.find('technique_common/accessor')
    array = source.find('float_array')
    if accessor is None or array is None:
        return
    stride, start = int(accessor.get('stride', len(names))), int(accessor.get('offset', '0'))
    if stride != len(names) or start:
        values = (array.text or '').split()[start:]
        rows = np.array(values[:len(values) // stride * stride]).reshape(-1, stride)
        array.text = ' '.join(rows[:, :len(names)].ravel().tolist())
    for child in list(accessor):
        accessor.remove(child)
    for name in names:
        ElementTree.SubElement(accessor, 'param', name=name, type='float')
