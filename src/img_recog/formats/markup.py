"""Reads XML that others wrote: what a parser cannot take is one error, with one line."""
import re
import xml.etree.ElementTree as ElementTree
from typing import Any, List, Match, NamedTuple, Optional, Tuple, Union
from xml.parsers import expat

from img_recog.errors import UserError, one_line, shortened

_MAX_NAMES = 600000         # of elements and attributes
# Of what is no element, CDATA remains.
_CDATA = '<![CDATA['
_OTHERS = (('<!--', '-->'), (_CDATA, ']]>'), ('<?', '?>'), ('<!', '>'))
_TAG = re.compile(r'<(/?)([^\W\d][^\s<>/="\'&]*)')
_ATTRIBUTE = re.compile(r'\s*([^\s<>/="\']+)\s*=\s*'
                        r'(?:"([^"]*)"|\'([^\']*)\'|([^\s/>"\']+)(?=[\s/>]))')
_END_OF_TAG = re.compile(r'\s*(/?)>')
_BARE_AMPERSAND = re.compile('&(?!(?:amp|lt|gt|quot|apos|#[0-9]+|#x[0-9a-fA-F]+);)')
_CONTROL = re.compile('[\x01-\x08\x0b\x0c\x0e-\x1f]')
MAX_BYTES = 1 << 24
# A URDF has 8 levels at most; Python's own functions for trees fail at about 300.
_MAX_DEPTH = 100
_MAX_ATTRIBUTE, _MAX_TEXT = 10000, 100000      # characters
_MAX_ELEMENTS, _MAX_ATTRIBUTES, _MAX_OF_ELEMENT = 200000, 400000, 1000
# Expat reads a whole tag before it can be refused: 300 bytes for each attribute. No tag has a <.
_MAX_TAG = 1 << 22                              # characters up to the next <
_LONG_TAG = '<[^<]{%d}' % _MAX_TAG
_MAKE_NOTHING = ('xacro:arg', 'xacro:macro', 'xacro:property')


class _Part(NamedTuple):
    """A tag, a comment or similar.

    text: as it is in XML, for a tag without `closing`; end: where it ends in the source; change:
    of the depth; names: of the element and its attributes, none for what is no tag.
    """

    text: str
    end: int
    closing: str = ''
    change: int = 0
    names: Tuple[str, ...] = ()


def repaired(source: Union[str, bytes]) -> Optional[Union[str, bytes]]:
    """Return XML with what TinyXML reads in a text; None if it reads nothing.

    It takes a declaration that is not at the start, texts around the root element, a & that begins
    no entity, a < in an attribute, attributes without quotes or without a space between them, --
    in a comment, and undeclared prefixes of names. The result may still not be XML.
    """
    if isinstance(source, bytes):
        # any byte is a character, so that only those in comments need not be UTF-8
        found = repaired(source.decode('latin-1'))
        return found.encode('latin-1') if isinstance(found, str) else None
    parts: List[str] = []
    names: List[str] = []
    root, position, depth = -1, 0, 0    # root: where the tag of that is in `parts`
    declared: Tuple[str, ...] = ()
    while root < 0 or depth > 0:
        start = source.find('<', position)
        part = None if start < 0 else _other(source, start) or _tag(source, start)
        if part is None or len(names) > _MAX_NAMES:
            return None
        text = source[position:start]
        parts.append(_escaped(text) if depth else '')
        if part.names and root < 0:
            root, declared = len(parts), part.names
        depth, position = depth + part.change, part.end
        names += part.names
        parts += [part.text, part.closing]
    prefixes = {name.split(':')[0] for name in names if ':' in name} - {'xml', 'xmlns'}
    parts[root] += ''.join(' xmlns:{0}="{0}"'.format(prefix) for prefix in sorted(prefixes)
                           if 'xmlns:' + prefix not in declared)
    return ''.join(parts)


def _other(source: str, start: int) -> Optional[_Part]:
    """Return what is no tag of an element; None for that, and for what does not end."""
    for opening, closing in _OTHERS:
        if source.startswith(opening, start):
            end = source.find(closing, start + len(opening)) + len(closing)
            return None if end < len(closing) else _Part(
                source[start:end] if opening == _CDATA else '', end)
    return None


def _tag(source: str, start: int) -> Optional[_Part]:
    opening = _TAG.match(source, start)
    if opening is None:
        return None
    names, position = [opening.group(2)], opening.end()
    written = ['<' + opening.group(1) + names[0]]
    attribute: Optional[Match[str]] = _ATTRIBUTE.match(source, position)
    while attribute is not None:
        names.append(attribute.group(1))
        value = next(each for each in attribute.groups()[1:] if each is not None)
        written.append('{}="{}"'.format(names[-1], _escaped(value).replace('<', '&lt;')
                                        .replace('"', '&quot;')))
        position = attribute.end()
        attribute = _ATTRIBUTE.match(source, position)
    end = _END_OF_TAG.match(source, position)
    if end is None:
        return None
    change = -1 if opening.group(1) else 0 if end.group(1) else 1
    return _Part(' '.join(written), end.end(), end.group(1) + '>', change, tuple(names))


def _escaped(text: str) -> str:
    return _CONTROL.sub(' ', _BARE_AMPERSAND.sub('&amp;', text))


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
        other = repaired(text)
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
