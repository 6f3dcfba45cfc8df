"""What a file asks for that is not done here, and what of it is not known."""
import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Iterator, List, Tuple

from img_recog.errors import most_similar
from img_recog.formats.reader import FALSE, TRUE, is_true
from img_recog.formats.schema import (ATTRIBUTES, KNOWN_PLUGINS, MODEL_PLUGINS, PLUGIN_NAMES,
                                      SIMULATED, WITHOUT_ROS, Child, children_of, row_of)
from img_recog.report import NOT_KNOWN, NOT_SIMULATED, NOT_UNIQUE, NOT_USED, Finding

_UNIQUE = ('model', 'link', 'joint', 'visual', 'collision')     # by their names, in one parent
_NAMED = ('model', 'link', 'joint')
# of which an element can have several
_MANY = frozenset('world model link joint collision visual sensor light plugin include population '
                  'road frame point texture blend gazebo transmission material gripper uri '
                  'camera polyline'.split())
_TOLD = ('plugin', 'sensor', 'light', 'actor')    # which one it is
_FRICTIONS = ('mu', 'mu1', 'mu2')
_PLUGINS = (*KNOWN_PLUGINS, *MODEL_PLUGINS)
_SHORT_NAMES = [word.split('_', 2)[2] for word in _PLUGINS if word.startswith('gazebo_ros_')]
_PLUGIN_FILE = re.compile(r'(?:lib)?(gazebo_?(?:ros_?)?)?(.*?)(?:\.so)?', re.DOTALL)
_SIMILAR_NAME = 0.8         # many packages have plugins of their own, whose names are not these
_FILE = 'the file'          # the place of what is in no element with a name


def audit(root: ElementTree.Element) -> List[Finding]:
    """Return what an <sdf> or a <robot> asks for that is not simulated, and what is not known.

    The findings are in the order of the file.
    """
    return [Finding(kind, what, (place,)) for kind, what, place in _found(
        root, (root.tag,), _below('', root) or _FILE)]


_Found = Tuple[str, str, str]


def _found(element: ElementTree.Element, path: Tuple[str, ...], place: str) -> Iterator[_Found]:
    row = row_of(path)
    if row.anything:
        yield from _parameters(element, place)
        return
    children = children_of(row)
    for name in element.keys():
        if name not in ATTRIBUTES[path[0]] and not name.startswith('{'):
            yield NOT_KNOWN, 'attribute {} of <{}>'.format(name, element.tag), place
    yield from _names(element, place)
    seen = set()
    for child in element:
        # neither a comment nor of another format, like sdformat's <gz:...> and <drake:...>
        if not isinstance(child.tag, str) or ':' in child.tag or child.tag.startswith('{'):
            continue
        tag, inner = child.tag, (*path, child.tag)
        state, kind, default = children.get(tag, Child(NOT_KNOWN))
        if inner[-2:] == ('model', 'plugin') and any(
                word in child.get('filename', '') for word in MODEL_PLUGINS):
            yield from _parameters(child, _below(place, child))
            continue
        meant = _meant(child.get('filename', '')) if tag == 'plugin' else ''
        if meant:
            yield NOT_KNOWN, '{} (did you mean libgazebo_ros_{}.so?)'.format(
                _label(child), meant), place
            continue
        if state == NOT_KNOWN or state == NOT_SIMULATED and (
                default is None or not _changes_nothing(element, child, default)):
            yield state, _label(child) if tag in _TOLD else '<{}>'.format(tag), place
        elif state == SIMULATED:
            group = 'shape' if element.tag == 'geometry' else tag
            if group in seen and group not in _MANY:
                yield NOT_USED, 'second {}<{}>'.format('shape ' * (group != tag), tag), place
            seen.add(group)
            if kind == 'bool':
                yield from _boolean(child, place)
            if tag in _FRICTIONS and _value(child).startswith('-'):
                yield NOT_USED, '<{0}>{1}</{0}>, which means unlimited friction in Gazebo,'.format(
                    tag, _value(child)), place
            yield from _found(child, inner, _below(place, child))


def _parameters(plugin: ElementTree.Element, place: str) -> Iterator[_Found]:
    """Yield what a plugin of gazebo_ros does not read."""
    if any(word in plugin.get('filename', '') for word in KNOWN_PLUGINS):
        for child in plugin:
            if isinstance(child.tag, str) and child.tag not in PLUGIN_NAMES:
                yield NOT_KNOWN, '<{}>'.format(child.tag), place


def _meant(file: str) -> str:
    """Return the name of the plugin of gazebo_ros that a file name means, '' if it means another.

    >>> _meant('libgazebo_ros_difdrive.so'), _meant('libRayPlugin.so')
    ('diff_drive', 'laser')
    """
    prefix, name = _PLUGIN_FILE.fullmatch(file).groups()       # type: ignore[union-attr]
    if not prefix or any(word in file for word in _PLUGINS):
        return WITHOUT_ROS.get(name, '')
    return most_similar(name, _SHORT_NAMES, _SIMILAR_NAME)


def _changes_nothing(parent: ElementTree.Element, element: ElementTree.Element,
                     default: str) -> bool:
    """Return whether all values in an element are `default`, or it has none."""
    if default.startswith('<'):
        default = next(map(_value, parent.findall(default.strip('<>'))), '')
    return all(_same(text, default) for text in filter(None, map(_value, element.iter())))


def _value(element: ElementTree.Element) -> str:
    return (element.text or '').strip() or element.get('value', '')


def _same(text: str, default: str) -> bool:
    if text.lower() in TRUE + FALSE and default in TRUE + FALSE:
        return is_true(text) == is_true(default)
    try:
        values = [float(value) for value in text.split()]
        wanted = [float(value) for value in default.split(',')]
    except ValueError:
        return text == default
    # an opacity may be omitted
    return all(math.isclose(*pair, rel_tol=1e-6, abs_tol=1e-9) for pair in zip(values, wanted))


def _boolean(element: ElementTree.Element, place: str) -> Iterator[_Found]:
    text = (element.text or '').strip()
    if text.lower() not in TRUE + FALSE:
        yield NOT_KNOWN, '<{}>{}</{}>, which is neither true nor false,'.format(
            element.tag, text, element.tag), place


def _names(element: ElementTree.Element, place: str) -> Iterator[_Found]:
    """Yield what has no name, and names that several have."""
    seen = set()
    for child in element:
        name = child.get('name')
        if not name:
            if child.tag in _NAMED and element.tag not in ('include', 'state'):
                yield NOT_KNOWN, '<{}> without a name'.format(child.tag), place
        # of models in a world, the reader of worlds says so: included ones are among them
        elif child.tag in _UNIQUE and not (child.tag == 'model' and element.tag == 'world'):
            if (child.tag, name) in seen:
                yield NOT_UNIQUE, 'the name {}'.format(_label(child)), place
            seen.add((child.tag, name))
    if element.tag == 'model' and element.get('placement_frame'):
        yield NOT_SIMULATED, 'placement_frame', place
    if element.tag == 'sdf':
        for world in element.findall('world')[1:]:
            yield NOT_USED, 'second ' + _label(world), place


def _label(element: ElementTree.Element) -> str:
    name = element.get('filename') or element.get('name') or element.get('reference')
    return '{} {}'.format(element.tag, name) if name else '<{}>'.format(element.tag)


def _below(place: str, element: ElementTree.Element) -> str:
    """Return the place of what is in an element: the last two names."""
    label = _label(element)
    if label.startswith('<'):
        return place
    return label if place in ('', _FILE) else ' '.join([*place.split(' ')[-2:], label])
