"""Refuses DAE files with which PyBullet would crash or never end.

PyBullet's reader (LoadMeshFromCollada.cpp) uses each element, attribute and index without a check
of whether it exists. What is checked here is what it uses, in the order in which it reads it.
"""
import re
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, Optional
from xml.parsers import expat

import numpy as np

from img_recog.errors import shortened

MAX_TRIANGLES = 5000000
_MAX_DEPTH, _MAX_OFFSET = 100, 100
_MAX_NUMBER = float(np.finfo(np.float32).max)
_TRANSFORMS = ('matrix', 'translate', 'scale', 'rotate')
_COMMENT = '!'      # the tag of a comment: text after one is not read
_Sources = Dict[str, ElementTree.Element]


class DamagedMesh(Exception):
    """Why the file of a mesh cannot be used."""


def check(path: str) -> None:
    """Raise DamagedMesh, or expat.ExpatError, unless PyBullet can read the file."""
    root = _parsed(path)
    asset = _child(root, 'asset')
    unit, up_axis = asset.find('unit'), asset.find('up_axis')
    if unit is not None and _numbers('<unit meter>', _attribute(unit, 'meter'))[0] <= 0:
        raise DamagedMesh('its <unit> has the length {}'.format(shortened(unit.get('meter'))))
    if up_axis is not None:
        _text(up_axis)
    counts: Dict[str, int] = {}
    sources: _Sources = {}
    positions: Dict[str, _Sources] = {}
    for geometry in _child(root, 'library_geometries').findall('geometry'):
        counts[_attribute(geometry, 'id')] = sum(
            _check_mesh(mesh, sources, positions) for mesh in geometry.findall('mesh'))
    _check_scenes(root, counts)


def _parsed(path: str) -> ElementTree.Element:
    """Return the root element; tags have their prefixes, which PyBullet does not remove."""
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    depth = 0

    def start(tag: str, attributes: Dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _MAX_DEPTH:
            raise DamagedMesh('it is nested more than {} levels deep'.format(_MAX_DEPTH))
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def comment(*_: str) -> None:
        if depth:
            builder.start(_COMMENT, {})
            builder.end(_COMMENT)

    def refuse_entity(name: str, *_: object) -> None:
        raise DamagedMesh('it has the entity {}'.format(name))

    def refuse_section() -> None:
        raise DamagedMesh('it has a CDATA section')

    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.CommentHandler = parser.ProcessingInstructionHandler = comment
    parser.EntityDeclHandler = refuse_entity
    parser.StartCdataSectionHandler = refuse_section
    with open(path, 'rb') as file:
        parser.ParseFile(file)
    return builder.close()


def _check_mesh(mesh: ElementTree.Element, sources: _Sources,
                positions: Dict[str, _Sources]) -> int:
    """Check a <mesh>; return its number of triangles.

    sources: all <source>s up to here, by id; positions: the <source>s of all <vertices> up to
    here, by the id of those and the semantic. Both are added to.
    """
    vertices = _child(mesh, 'vertices')
    for source in mesh.findall('source'):
        sources[_attribute(source, 'id')] = source
    found: _Sources = {}
    for each in vertices.findall('input'):
        semantic, source_id = _attribute(each, 'semantic'), _attribute(each, 'source')[1:]
        if semantic in ('POSITION', 'NORMAL'):
            if source_id in sources:
                found[semantic] = sources[source_id]
            elif semantic == 'POSITION':
                raise DamagedMesh('it has no <source> {}'.format(shortened(source_id)))
    positions[_attribute(vertices, 'id')] = found
    return sum(_check_triangles(each, sources, positions)
               for tag in ('triangles', 'polylist') for each in mesh.findall(tag))


def _check_triangles(element: ElementTree.Element, sources: _Sources,
                     positions: Dict[str, _Sources]) -> int:
    """Check a <triangles> or <polylist>; return its number of triangles."""
    stride = 1
    found: Dict[str, ElementTree.Element] = {}
    offsets: Dict[str, int] = {}
    for each in element.findall('input'):
        semantic, source_id = _attribute(each, 'semantic'), _attribute(each, 'source')[1:]
        offset = _count(each, 'offset', _MAX_OFFSET)
        stride = max(stride, offset + 1)
        if semantic == 'VERTEX':
            if source_id not in positions:
                raise DamagedMesh('it has no <vertices> {}'.format(shortened(source_id)))
            found.update(positions[source_id])
            offsets.update(dict.fromkeys(positions[source_id], offset))
        elif semantic == 'NORMAL' and source_id in sources:
            found['NORMAL'], offsets['NORMAL'] = sources[source_id], offset
    if 'POSITION' not in found:
        raise DamagedMesh('a <{}> has no positions'.format(element.tag))
    count = _count(element, 'count', MAX_TRIANGLES)
    name = '<p> of a <{}>'.format(element.tag)
    words = _words(_text(_child(element, 'p')))
    if len(words) < 3 * count * stride:
        raise DamagedMesh('{} has {} numbers, expected {}'.format(
            name, len(words), 3 * count * stride))
    indices = _integers(name, words)[:3 * count * stride].reshape(-1, stride)
    for semantic, source in found.items():
        _check_indices(indices[:, offsets[semantic]], _array(source))
    return count


def _check_indices(indices: np.ndarray, values: np.ndarray) -> None:
    count = len(values) // 3
    # PyBullet keeps the indices as 32 bit floating point numbers
    used = indices.astype(np.float32).astype(np.int64)
    if len(used) and (used.min() < 0 or used.max() >= count):
        wrong = indices.min() if used.min() < 0 else indices.max()
        raise DamagedMesh('a triangle refers to number {} of {}, the first is 0'.format(
            wrong, count))


def _array(source: ElementTree.Element) -> np.ndarray:
    """Return the numbers in a <source>; they are separated by spaces and line breaks."""
    array = source.find('float_array')
    if array is None:
        return np.array([])
    _child(_child(source, 'technique_common'), 'accessor')
    values = _numbers('<float_array>', _text(array))
    if _count(array, 'count', 1 << 31) != len(values):
        raise DamagedMesh('a <float_array> has {} numbers, expected {}'.format(
            len(values), array.get('count')))
    return values


def _check_scenes(root: ElementTree.Element, counts: Dict[str, int]) -> None:
    """Check the visual scenes; counts: of triangles, by the id of the geometry."""
    library = root.find('library_visual_scenes')
    if library is None:
        return
    for instance in root.findall('scene/instance_visual_scene'):
        _reference(instance)
    total = 0
    for scene in library.findall('visual_scene'):
        _attribute(scene, 'id')
        for element in scene.iter():
            if element.tag == 'instance_geometry':
                total += counts.get(_reference(element), 0)
            elif element.tag in _TRANSFORMS:
                _numbers('<{}>'.format(element.tag), element.text or '0')
            tags = [child.tag for child in element]
            after = tags[tags.index('node'):] if 'node' in tags else []
            for tag in set(_TRANSFORMS).intersection(after):
                raise DamagedMesh('a <{}> follows a <node>'.format(tag))    # read without end
    if total > MAX_TRIANGLES:
        raise DamagedMesh('it has {} triangles, more than {}'.format(total, MAX_TRIANGLES))


def _child(parent: ElementTree.Element, tag: str) -> ElementTree.Element:
    child = parent.find(tag)
    if child is None:
        raise DamagedMesh('its <{}> has no <{}>'.format(shortened(parent.tag), tag))
    return child


def _attribute(element: ElementTree.Element, name: str) -> str:
    value = element.get(name)
    if value is None:
        raise DamagedMesh('a <{}> in it has no {}'.format(element.tag, name))
    return value


def _reference(element: ElementTree.Element) -> str:
    """Return the id that the attribute url refers to."""
    url = _attribute(element, 'url')
    if not url:
        raise DamagedMesh('a <{}> in it has an empty url'.format(element.tag))
    return url[1:]


def _count(element: ElementTree.Element, name: str, most: int) -> int:
    value = _integers('<{} {}>'.format(element.tag, name), [_attribute(element, name)])[0]
    if not 0 <= value <= most:
        raise DamagedMesh('<{} {}> in it is {}, expected 0 to {}'.format(
            element.tag, name, value, most))
    return int(value)


def _text(element: ElementTree.Element) -> str:
    if not (element.text or '').strip() or len(element):
        raise DamagedMesh('a <{}> in it has {}'.format(
            element.tag, 'more than text' if len(element) else 'no text'))
    return element.text or ''


def _words(text: str) -> List[str]:
    return [word for word in re.split('[ \n]', text) if word]


def _integers(name: str, words: List[str]) -> np.ndarray:
    try:
        return np.array([int(word) for word in words], np.int64)
    except (ValueError, OverflowError):
        raise DamagedMesh('{} has something that is not a whole number'.format(name))


def _numbers(name: str, text: str) -> np.ndarray:
    try:
        values: Optional[np.ndarray] = np.array([float(word) for word in _words(text)])
    except ValueError:
        values = None
    if values is None or not np.all(np.abs(values) <= _MAX_NUMBER):
        raise DamagedMesh('{} has something that is not a finite number'.format(name))
    return values if len(values) else np.zeros(1)
