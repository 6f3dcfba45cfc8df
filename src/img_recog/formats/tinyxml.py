"""What TinyXML, with which Gazebo reads all files, takes for XML."""
import re
from typing import List, Match, NamedTuple, Optional, Tuple, Union

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
