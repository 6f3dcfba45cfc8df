"""Reads YAML that others wrote: what a parser cannot take is one error, with one line."""
import functools
import math
import re
from typing import Any, Dict, Set

from img_recog.errors import one_line, shortened
from img_recog.formats.markup import MarkupError, read_bytes

_MAX_BYTES = 1 << 20     # of a file that a user writes
_MERGE = '<<'            # a key of YAML that takes over those of another mapping


@functools.lru_cache(maxsize=None)
def _yaml_loader() -> Any:
    """Return PyYAML's loader with the angles that rosparam knows, which it makes radians."""
    import yaml

    class Loader(yaml.SafeLoader):
        """A class of its own, so that other users of PyYAML do not get the angles."""

    for tag, function, unit in (('!degrees', 'deg', math.pi / 180), ('!radians', 'rad', 1.0)):
        Loader.add_constructor(tag, lambda loader, node, unit=unit: unit * _angle(
            loader.construct_scalar(node)))
        Loader.add_implicit_resolver(tag, re.compile(function + r'\(.*\)$'), function[0])
    return Loader


def _angle(text: str) -> float:
    """Return the value of a number in a text, or of a product or quotient with pi.

    >>> _angle('deg(120)'), _angle('-pi/2')
    (120.0, -1.5707963267948966)
    """
    found = re.fullmatch(r'\s*(?:(?:deg|rad)\((.*)\)|(.*))\s*', text)
    first, *rest = re.split('([*/])', (found and (found.group(1) or found.group(2))) or '')
    value = _factor(first)
    for operator, word in zip(rest[::2], rest[1::2]):
        value = value * _factor(word) if operator == '*' else value / _factor(word)
    return value


def _factor(word: str) -> float:
    return {'pi': math.pi, '-pi': -math.pi}.get(word.strip()) or float(word)


def read_yaml(path: str) -> Any:
    """Return the content of a YAML file; raise OSError or, as `load_yaml`, MarkupError."""
    return load_yaml(read_bytes(path, _MAX_BYTES))


def load_yaml(text: bytes) -> Any:
    """Return the content of a YAML text; raise MarkupError if it cannot be read.

    Aliases can make a small text a tree of any size: check its types before it is printed.
    """
    import yaml  # takes time, and few need it
    try:
        loader = _yaml_loader()(text)
        node = loader.get_single_node()
        _refuse_twice(loader, node, set())
        return None if node is None else loader.construct_document(node)
    except MarkupError:
        raise
    except RecursionError:
        raise MarkupError('nested too deeply')
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = ', line {}, column {}'.format(mark.line + 1, mark.column + 1) if mark else ''
        raise MarkupError('no YAML{}: {}'.format(where, shortened(error.problem or 'unreadable')))
    # PyYAML's constructors raise nearly everything: for !!int "" an IndexError
    except Exception as error:
        raise MarkupError(one_line(error))


def _refuse_twice(loader: Any, node: Any, known: Set[int]) -> None:
    """Raise MarkupError if a mapping of YAML has a key twice: PyYAML would take the last one.

    1, 1.0 and true are one key in Python.
    """
    if id(node) in known or not isinstance(getattr(node, 'value', None), list):
        return
    known.add(id(node))     # by an alias, it may be in many places
    first: Dict[Any, Any] = {}
    for each in node.value:
        parts = each if isinstance(each, tuple) else (each,)
        if len(parts) > 1 and isinstance(parts[0].value, str) and parts[0].value != _MERGE:
            key = loader.construct_object(parts[0])
            if key in first:
                both = first[key], parts[0]
                raise MarkupError('{} is given twice, in lines {} and {}'.format(
                    ' or '.join(dict.fromkeys(shortened(each.value) for each in both)),
                    *(each.start_mark.line + 1 for each in both)))
            first[key] = parts[0]
        for part in parts:
            _refuse_twice(loader, part, known)
