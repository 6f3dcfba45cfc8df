"""Reads XML and YAML that others wrote: what a parser cannot take is one error, with one line."""
import xml.etree.ElementTree as ElementTree
from typing import Any, Union
from xml.parsers import expat

from img_recog.errors import UserError, one_line, shortened

MAX_BYTES = 1 << 26
# A URDF has 8 levels at most; Python's own functions for trees fail at about 300.
_MAX_DEPTH = 100
_MAX_ATTRIBUTE, _MAX_TEXT = 10000, 100000      # characters


class MarkupError(UserError):
    """A text is not XML or YAML, or it is too deep or too large to be used."""


def read_bytes(path: str, max_bytes: int = MAX_BYTES) -> bytes:
    """Return the content of a file; raise OSError, and MarkupError if it is too large."""
    with open(path, 'rb') as file:
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:
        raise MarkupError('larger than {} bytes'.format(max_bytes))
    return content


def parse_xml(text: Union[str, bytes]) -> ElementTree.Element:
    """Return the root element of an XML text; raise MarkupError as `check_xml` does."""
    check_xml(text)
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise MarkupError('not XML: {}'.format(one_line(error)))


def check_xml(text: Union[str, bytes]) -> None:
    """Raise MarkupError unless a text is XML with few levels, short texts and no entities.

    Entities that contain entities can make a gigabyte of a line; expat has a limit only from
    2.4.0 on, which Ubuntu 20.04 does not have.
    """
    parser = expat.ParserCreate()
    depth = length = 0

    def start(_tag, attributes):
        nonlocal depth, length
        depth, length = depth + 1, 0
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
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise MarkupError('not XML: {}'.format(one_line(error)))


def load_yaml(text: bytes) -> Any:
    """Return the content of a YAML text; raise MarkupError if it cannot be read.

    Aliases can make a small text a tree of any size: check its types before it is printed.
    """
    import yaml  # takes time, and few need it
    try:
        return yaml.safe_load(text)
    except RecursionError:
        raise MarkupError('nested too deeply')
    # PyYAML's constructors raise nearly everything: for !!int "" an IndexError
    except Exception as error:
        raise MarkupError(one_line(error))
