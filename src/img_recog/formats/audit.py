"""What a file asks for that is not done here, and what of it is not known."""
import math
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from img_recog.formats.elements import BOOLEANS, NOT_SIMULATED, SDF, URDF, Row

NOT_KNOWN, NOT_USED, NOT_UNIQUE = 'not known', 'not used', 'not unique'
_FORMATS: Mapping[str, Mapping[str, Row]] = {'sdf': SDF, 'robot': URDF}
_UNIQUE = ('model', 'link', 'joint', 'visual', 'collision')     # by their names, in one parent
_NAMED = ('model', 'link', 'joint')
_TOLD = ('plugin', 'sensor', 'light', 'actor')    # which one it is
_WORDS = {'true': True, '1': True, 'false': False, '0': False}
_MAX_PLACES = 3             # that are named
_FILE = 'the file'          # the place of what is in no element with a name


class Finding(NamedTuple):
    """What is not done as asked; state: one of the constants; places: names like model/link."""

    state: str
    what: str
    places: Tuple[str, ...]

    def text(self) -> str:
        """Return it for the user.

        >>> Finding('not known', '<modle>', ('world default',)).text()
        '<modle> of world default'
        """
        return '{} of {}'.format(self.what, self.places_text())

    def places_text(self) -> str:
        """Return the first places, and how many more there are."""
        more = len(self.places) - _MAX_PLACES
        return ', '.join(self.places[:_MAX_PLACES]) + ' and {} more'.format(more) * (more > 0)


def audit(root: ElementTree.Element) -> List[Finding]:
    """Return what an <sdf> or a <robot> asks for that is not simulated, and what is not known.

    Equal findings are one, with all of their places, in the order of the file.
    """
    return list(merged(Finding(state, what, (place,)) for state, what, place in _found(
        root, (root.tag,), _below('', root) or _FILE, _FORMATS[root.tag])))


def merged(findings: Iterable[Finding]) -> Tuple[Finding, ...]:
    """Return findings of which equal ones are one."""
    places: Dict[Tuple[str, str], Dict[str, None]] = {}
    for finding in findings:
        places.setdefault(finding[:2], {}).update(dict.fromkeys(finding.places))
    return tuple(Finding(*key, tuple(found)) for key, found in places.items())


def warnings(name: str, findings: Sequence[Finding]) -> List[str]:
    """Return a line for each state; name: of the world, model or robot."""
    return ['{}: {}: {}'.format(name, state, ', '.join(
        finding.text() for finding in findings if finding.state == state))
            for state in dict.fromkeys(finding.state for finding in findings)]


_Found = Tuple[str, str, str]


def _found(element: ElementTree.Element, path: Tuple[str, ...], place: str,
           table: Mapping[str, Row]) -> Iterator[_Found]:
    row = _row(path, table)
    if row is None:
        row = Row()
    elif row.anything:
        return
    yield from _names(element, place)
    for child in element:
        if not isinstance(child.tag, str):      # a comment
            continue
        tag, inner = child.tag, (*path, child.tag)
        state = _state(element, child, row)
        if _is_foreign(tag):
            continue
        if state == NOT_KNOWN or state == NOT_SIMULATED:
            yield state, _label(child) if tag in _TOLD else '<{}>'.format(tag), place
        elif state:
            if tag in BOOLEANS or '/'.join(inner[-2:]) in BOOLEANS:
                yield from _boolean(child, place)
            if tag == 'pose':
                yield from _pose(child, place)
            yield from _found(child, inner, _below(place, child), table)


def _row(path: Sequence[str], table: Mapping[str, Row]) -> Optional[Row]:
    """Return the row of the longest end of a path; None without one."""
    for start in range(len(path)):
        row = table.get('/'.join(path[start:]))
        if row is not None:
            return row
    return None


def _state(parent: ElementTree.Element, child: ElementTree.Element, row: Row) -> str:
    """Return what becomes of a child, '' for nothing to be looked at."""
    if child.tag in row.simulated.split() or child.tag in row.drawn.split():
        return 'used'
    for word in row.no_effect.split():
        if word.partition('=')[0] == child.tag:
            return ''
    for word in row.not_simulated.split():
        name, has_default, default = word.partition('=')
        if name == child.tag:
            if default.startswith('<'):
                default = next(map(_value, parent.findall(default.strip('<>'))), '')
            return '' if has_default and _changes_nothing(child, default) else NOT_SIMULATED
    return NOT_KNOWN


def _changes_nothing(element: ElementTree.Element, default: str) -> bool:
    """Return whether all values in an element are `default`, or it has none."""
    texts = filter(None, map(_value, element.iter()))
    return all(_same(text, default) for text in texts)


def _value(element: ElementTree.Element) -> str:
    return (element.text or '').strip() or element.get('value', '')


def _same(text: str, default: str) -> bool:
    if text.lower() in _WORDS and default in _WORDS:
        return _WORDS[text.lower()] == _WORDS[default]
    try:
        values = [float(value) for value in text.split()]
        wanted = [float(value) for value in default.split(',')]
    except ValueError:
        return text == default
    # an opacity may be omitted
    return all(math.isclose(*pair, rel_tol=1e-6, abs_tol=1e-9) for pair in zip(values, wanted))


def _boolean(element: ElementTree.Element, place: str) -> Iterator[_Found]:
    text = (element.text or '').strip()
    if text.lower() not in _WORDS:
        yield NOT_KNOWN, '<{}>{}</{}>, which is neither true nor false,'.format(
            element.tag, text, element.tag), place


def _pose(element: ElementTree.Element, place: str) -> Iterator[_Found]:
    for name in element.keys():
        if name not in ('relative_to', 'frame', 'degrees', 'rotation_format'):
            yield NOT_KNOWN, 'attribute {} of <pose>'.format(name), place


def _names(element: ElementTree.Element, place: str) -> Iterator[_Found]:
    """Yield what has no name, and names that several have."""
    seen = set()
    for child in element:
        if child.tag in _NAMED and not child.get('name') and not (
                element.tag == 'include' or element.tag == 'state'):
            yield NOT_KNOWN, '<{}> without a name'.format(child.tag), place
        key = child.tag, child.get('name')
        # of models in a world, the reader of worlds says so: included ones are among them
        if child.tag in _UNIQUE and child.get('name') and (*key, element.tag)[::2] != (
                'model', 'world'):
            if key in seen:
                yield NOT_UNIQUE, 'the name {}'.format(_label(child)), place
            seen.add(key)
    worlds = element.findall('world')
    if element.tag == 'sdf' and len(worlds) > 1:
        for world in worlds[1:]:
            yield NOT_USED, 'second ' + _label(world), place


def _is_foreign(tag: str) -> bool:
    """Return whether an element is of another format, like sdformat's <gz:...> and <drake:...>."""
    return ':' in tag or tag.startswith('{')


def _label(element: ElementTree.Element) -> str:
    name = element.get('filename') or element.get('name') or element.get('reference')
    return '{} {}'.format(element.tag, name) if name else '<{}>'.format(element.tag)


def _below(place: str, element: ElementTree.Element) -> str:
    """Return the place of what is in an element: the last two names."""
    label = _label(element)
    if label.startswith('<'):
        return place
    return label if place in ('', _FILE) else ' '.join([*place.split(' ')[-2:], label])
