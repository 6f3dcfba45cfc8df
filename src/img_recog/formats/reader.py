"""The reader of values in XML elements: names, texts, and what schema.py gives a type."""
import functools
import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional

import numpy as np

from img_recog.errors import SimulationError
from img_recog.formats.schema import Child, children_of, row_of
from img_recog.model import ALL_BITS
from img_recog.settings import computable

TRUE, FALSE = ('true', '1'), ('false', '0')     # in any case
_MAX_LENGTH = 1e6
MAX_COUNT = 5000
_MAX_FRICTION = 100.0       # the forces of larger coefficients are not computable
_INFINITE = re.compile('[-+]?inf(inity)?', re.IGNORECASE)
_WHOLE = re.compile(r'\s*([-+]?)(0[xX][0-9a-fA-F]+|[0-9]{1,9}(?![0-9]))')
_VECTOR = re.compile('([0-9])(numbers|lengths|sizes)')


class Type(NamedTuple):
    """A type of values.

    Attributes:
        allowed: Which texts can be read, for messages.
        read: Function that returns the value of a text. It raises ValueError or KeyError if the
            text is not allowed.
        of_element: Whether `read` gets the element and its name for messages instead of a text;
            it raises SimulationError then.
    """

    allowed: str
    read: Callable[..., Any]
    of_element: bool = False


def name_of(element: ElementTree.Element) -> str:
    """Return the attribute `name`, '' without."""
    return element.get('name', '')


def text_of(element: ElementTree.Element, path: str) -> str:
    """Return the text of the first element at a path, without spaces around it; '' without.

    >>> text_of(ElementTree.fromstring('<link><mass> 2 </mass></link>'), 'mass')
    '2'
    """
    return element.findtext(path, '').strip()


def is_true(text: Optional[str]) -> bool:
    """Return whether the text of an element means true."""
    return (text or '').strip().lower() in TRUE


def value(element: ElementTree.Element, path: str, owner: str = '') -> Any:
    """Return the value of the first element at a path; the schema has its type and default.

    Args:
        element: Where the path begins.
        path: Names of elements, divided by slashes.
        owner: What the user knows the element by, for messages; by default its tag and name.

    Returns:
        The default if there is no such element, None if it has no default either.

    Raises:
        SimulationError: if the text cannot be read.

    >>> value(ElementTree.fromstring('<link><velocity_decay/></link>'), 'velocity_decay/linear')
    0.0
    """
    child = _child(element.tag, path)
    text = element.findtext(path)
    if text is None:
        if child.default is None:
            return None
        text = child.default.replace(',', ' ')
    return read(child.type, text, _label(element, path, owner))


def kind_of(tag: str, path: str) -> str:
    """Return the name of the type that the schema gives a value at a path in an element.

    >>> kind_of('collision', 'surface/contact/ode/kp')
    'positive'
    """
    return _child(tag, path).type


def required(element: ElementTree.Element, path: str, owner: str = '') -> Any:
    """Return a value as `value` does; SimulationError if there is none."""
    found = value(element, path, owner)
    return read(kind_of(element.tag, path), None, _label(
        element, path, owner)) if found is None else found


def values(element: ElementTree.Element, path: str, owner: str = '') -> List[Any]:
    """Return the values of all elements at a path; arguments and errors as for `value`."""
    kind, name = kind_of(element.tag, path), _label(element, path, owner)
    return [read(kind, each.text, name) for each in element.findall(path)]


def read(kind: str, text: Optional[str], name: str) -> Any:
    """Return the value of a text.

    Args:
        kind: Name of its type.
        text: Text of an element or an attribute, None without.
        name: What it is, for messages.

    Raises:
        SimulationError: if the text cannot be read.

    >>> read('3numbers', '0 -1.5 2', 'xyz of link a').tolist()
    [0.0, -1.5, 2.0]
    >>> read('share', '1.5', 'decay of link a'), read('limit', '+Inf', 'upper of joint a')
    (1.0, inf)
    """
    found = type_of(kind)
    try:
        return found.read(text or '')
    except ValueError:
        raise SimulationError('{}: got {!r}, expected {}'.format(name, text, found.allowed))


@functools.lru_cache(maxsize=None)
def type_of(kind: str) -> Type:
    """Return the type with a name, such as `number` or `3lengths`."""
    vector = _VECTOR.fullmatch(kind)
    if vector is None:
        return TYPES[kind]
    count, of = int(vector.group(1)), vector.group(2)
    return Type('{} {}'.format(count, _VECTORS[of][0]),
                lambda text: _VECTORS[of][1](_numbers(text, count)))


def _label(element: ElementTree.Element, path: str, owner: str) -> str:
    return '<{}> of {}'.format(path.rpartition('/')[2], owner or '{} {}'.format(
        element.tag, name_of(element)).strip())


@functools.lru_cache(maxsize=None)
def _child(tag: str, path: str) -> Child:
    *above, last = path.split('/')
    return children_of(row_of(('sdf', tag, *above)))[last]


def whole(text: str) -> int:
    """Return the whole number that a text begins with, as sdformat reads it; else ValueError.

    >>> whole('360.5'), whole('0x10'), whole('3.6e2')
    (360, 16, 3)
    """
    found = _WHOLE.match(text)
    if found is None:
        raise ValueError(text)
    return int(found.group(1) + found.group(2), 0 if 'x' in found.group(2).lower() else 10)


def number(text: str) -> float:
    """Return the finite number that is the first word of a text; else ValueError."""
    found = float(next(iter(text.split()), ''))
    if not math.isfinite(found):
        raise ValueError(text)
    return found


def flag(text: str) -> bool:
    """Return whether a text means true or false; ValueError if it means neither."""
    if text.strip().lower() not in TRUE + FALSE:
        raise ValueError(text)
    return is_true(text)


def _numbers(text: str, count: int) -> np.ndarray:
    found = [float(word) for word in text.split()]
    if len(found) != count or not all(map(math.isfinite, found)):
        raise ValueError(text)
    return np.array([computable(each) for each in found])


def _limit(text: str) -> float:
    return float(text) if _INFINITE.fullmatch(text.strip()) else computable(number(text))


def _count(text: str) -> int:
    found = whole(text)
    return _checked(found, 0 <= found <= MAX_COUNT)


def _lengths(found: np.ndarray) -> np.ndarray:
    return _checked(found, np.abs(found).max() <= _MAX_LENGTH)


def _sizes(found: np.ndarray) -> np.ndarray:
    return _checked(_lengths(found), (found > 0).all())


def _direction(text: str) -> np.ndarray:
    found = _numbers(text, 3)
    return _checked(found, found.any())


def _axis(text: str) -> np.ndarray:
    found = _direction(text)
    return found / np.linalg.norm(found)


def _coefficient(text: str) -> float:
    found = number(text)
    return _checked(computable(found), found >= 0)


def _friction(text: str) -> float:
    found = computable(number(text))
    return min(found, _MAX_FRICTION) if found >= 0 else _MAX_FRICTION


def _color(text: str) -> 'tuple[float, float, float, float]':
    found = _numbers(text + ' 1' * (len(text.split()) == 3), 4)
    red, green, blue, opacity = np.where(found > 1, found / 255, found).clip(0, 1).tolist()
    return red, green, blue, opacity


def _checked(found: Any, is_allowed: Any) -> Any:
    if not is_allowed:
        raise ValueError(found)
    return found


_AT_MOST = 'of at most {:g}'.format(_MAX_LENGTH)
_VECTORS: Dict[str, Any] = {
    'numbers': ('finite numbers', lambda found: found),
    'lengths': ('finite numbers ' + _AT_MOST, _lengths),
    'sizes': ('positive numbers ' + _AT_MOST, _sizes)}
NUMBER, WHOLE = Type('a finite number', number), Type('a whole number', whole)
FLAG = Type('true, false, 1 or 0', flag)
TYPES: Dict[str, Type] = {
    'text': Type('a text', str.strip),
    'bool': Type(FLAG.allowed, is_true),        # audit.py reports other words
    'number': Type(NUMBER.allowed, lambda text: computable(number(text))),
    'positive': Type(NUMBER.allowed, lambda text: max(0.0, computable(number(text)))),
    'share': Type(NUMBER.allowed, lambda text: min(max(computable(number(text)), 0.0), 1.0)),
    'mass': NUMBER,
    'limit': Type('a number', _limit),
    'whole': WHOLE,
    'count': Type('a whole number from 0 to {}'.format(MAX_COUNT), _count),
    'bits': Type('a whole number', lambda text: int(text, 0) & ALL_BITS),
    'length': Type('a finite number ' + _AT_MOST,
                   lambda text: float(_lengths(_numbers(text, 1))[0])),
    'size': Type('a positive number ' + _AT_MOST,
                 lambda text: float(_sizes(_numbers(text, 1))[0])),
    'coefficient': Type('a finite number of at least 0', _coefficient),
    # a negative one means as much friction as possible
    'friction': Type(NUMBER.allowed, _friction),
    'direction': Type('3 finite numbers, not all 0', _direction),
    'axis': Type('3 finite numbers, not all 0', _axis),
    # a part of more than 1 is one of 255; the opacity may be omitted
    'color': Type('3 or 4 finite numbers', _color)}


def words(numbers: Iterable[float]) -> str:
    """Return numbers as the text of an attribute; SimulationError if one is NaN.

    >>> words((1, 0.5))
    '1.0 0.5'
    """
    found = [float(each) for each in numbers]
    if any(map(math.isnan, found)):
        raise SimulationError('got the numbers {}, expected none that is nan'.format(found))
    return ' '.join(map(repr, found))
