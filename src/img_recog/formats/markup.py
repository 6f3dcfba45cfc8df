"""Reads XML that others wrote: what a parser cannot take is one error, with one line."""
import re
import xml.etree.ElementTree as ElementTree
from typing import Any, Union
from xml.parsers import expat

from img_recog.errors import UserError, one_line, shortened
from img_recog.formats import tinyxml

MAX_BYTES = 1 << 24
# A URDF has 8 levels at most; Python's own functions for trees fail at about 300.
_MAX_DEPTH = 100
_MAX_ATTRIBUTE, _MAX_TEXT = 10000, 100000      # characters
_MAX_ELEMENTS, _MAX_ATTRIBUTES, _MAX_OF_ELEMENT = 200000, 400000, 1000
# Expat reads a whole tag before it can be refused: 300 bytes for each attribute. No tag has a <.
_MAX_TAG = 1 << 22                              # characters up to the next <
_LONG_TAG = '<[^<]{%d}' % _MAX_TAG
_MAKE_NOTHING = ('xacro:arg', 'xacro:macro', 'xacro:property')


class MarkupError(UserError):
    """A text is not XML or YAML, or it is too deep or too large to be used."""


class _NotXmlError(MarkupError):
    """A text is not XML."""


def _not_xml(error: expat.ExpatError) -> _NotXmlError:
    if error.code == expat.errors.codes[expat.errors.XML_ERROR_NO_ELEMENTS]:
        return _NotXmlError('not XML: it is empty, or ends at line {} before the root element is '
                            'complete'.format(error.lineno))
    return _NotXmlError('not XML: {}'.format(one_line(error)))


def read_bytes(path: str, max_bytes: int = MAX_BYTES, opener: Any = None) -> bytes:
    """Return the content of a file; raise OSError, and MarkupError if it is too large.

    opener: `files.plain` for what a file names; a user may name a pipe.
    """
    with open(path, 'rb', opener=opener) as file:
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:
        raise MarkupError('larger than {} bytes'.format(max_bytes))
    return content


def parse_xml(text: Union[str, bytes]) -> ElementTree.Element:
    """Return the root element of an XML text, or of what TinyXML takes for one.

    Raises MarkupError as `check_xml` does.
    """
    try:
        return _parsed(text)
    except _NotXmlError as error:
        other = tinyxml.repaired(text)
        if other is None:
            raise
        try:
            return _parsed(other)
        except MarkupError:
            raise error


def _parsed(text: Union[str, bytes]) -> ElementTree.Element:
    check_xml(text)
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise _NotXmlError('not XML: {}'.format(one_line(error)))
    except (LookupError, ValueError) as error:
        raise MarkupError('not XML: {}'.format(one_line(error)))


def check_expanded(root: ElementTree.Element) -> str:
    """Raise MarkupError when something of a URDF or SDF is missing, because xacro would make it.

    Returns what is left over of xacro, like <xacro:property>, '' for nothing.
    """
    of_links = [element for tag in ('link', 'joint') for part in root.findall(tag)
                for element in part.iter()]
    names = [re.sub('.*}', 'xacro:', element.tag) for element in root.iter()
             if 'xacro}' in element.tag]
    found = [name for name in names if name not in _MAKE_NOTHING] + [
        element.tag for element in root if root.tag == 'robot' and element.tag == 'include'] + [
        '{} {}="{}"'.format(element.tag, *item) for element in of_links
        for item in element.items() if '${' in item[1] or '$(' in item[1]]
    if found:
        raise MarkupError(
            'it contains xacro (<{}>), which is not expanded'.format(shortened(found[0])),
            'give the file a name that ends with .xacro, or expand it: xacro FILE > robot.urdf'
            if found[0] != 'include' else 'xacro of Noetic expands only <xacro:include>')
    return '<{}>'.format(names[0]) if names else ''


def check_xml(text: Union[str, bytes]) -> None:
    """Raise MarkupError unless a text is XML of a usual size, with few levels and no entities.

    Entities that contain entities can make a gigabyte of a line; expat has a limit only from
    2.4.0 on, which Ubuntu 20.04 does not have.
    """
    _check_length(text)
    parser = expat.ParserCreate()
    depth = length = elements = attributes_count = 0

    def start(_tag, attributes):
        nonlocal depth, length, elements, attributes_count
        depth, length, elements = depth + 1, 0, elements + 1
        attributes_count += len(attributes)
        if elements > _MAX_ELEMENTS or attributes_count > _MAX_ATTRIBUTES:
            raise MarkupError('more than {} elements or {} attributes at line {}'.format(
                _MAX_ELEMENTS, _MAX_ATTRIBUTES, parser.CurrentLineNumber))
        if len(attributes) > _MAX_OF_ELEMENT:
            raise MarkupError('an element at line {} has {} attributes, allowed are {}'.format(
                parser.CurrentLineNumber, len(attributes), _MAX_OF_ELEMENT))
        if depth > _MAX_DEPTH:
            raise MarkupError('nested too deeply: more than {} levels at line {}'.format(
                _MAX_DEPTH, parser.CurrentLineNumber))
        for name, value in attributes.items():
            if len(value) > _MAX_ATTRIBUTE:
                raise MarkupError('attribute {} at line {} has {} characters, allowed are {}'
                                  .format(shortened(name), parser.CurrentLineNumber, len(value),
                                          _MAX_ATTRIBUTE))

    def end(_tag):
        nonlocal depth, length
        depth, length = depth - 1, 0

    def characters(text):
        nonlocal length
        length += len(text)
        if length > _MAX_TEXT:
            raise MarkupError('a text before line {} has more than {} characters'.format(
                parser.CurrentLineNumber + 1, _MAX_TEXT))

    def entity(*_):
        raise MarkupError('it declares entities, which are not supported', 'write them out')

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.EntityDeclHandler = characters, entity
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise _not_xml(error)
    except (LookupError, ValueError) as error:
        raise MarkupError('not XML: {}'.format(one_line(error)))


def _check_length(text: Union[str, bytes]) -> None:
    if len(text) > MAX_BYTES:
        raise MarkupError('larger than {} bytes'.format(MAX_BYTES))
    characters = text if isinstance(text, str) else text.decode('latin-1')
    found = re.search(_LONG_TAG, characters)
    if found:
        raise MarkupError('a tag, comment or text at line {} has more than {} characters'.format(
            characters.count('\n', 0, found.start()) + 1, _MAX_TAG))
