"""Labels of values in reports: as short as they can be, while no two are equal."""
import os
from collections import Counter
from typing import Any, List, Sequence


def unique(forms: Sequence[Sequence[str]]) -> List[str]:
    """Return the first form of each value that no other has, else its last one.

    The last forms of two values differ.

    >>> unique([['a', 'x/a'], ['a', 'y/a'], ['b', 'x/b']])
    ['x/a', 'y/a', 'b']
    """
    counts = Counter(form for each in forms for form in set(each))
    return [next((form for form in each if counts[form] == 1), each[-1]) for each in forms]


def of_path(path: str) -> List[str]:
    """Return the end of a path with more and more folders.

    >>> of_path('/data/a.bag')
    ['a.bag', 'data/a.bag', '/data/a.bag']
    """
    parts = path.split(os.sep)
    return [os.sep.join(parts[-length:]) for length in range(1, len(parts) + 1)]


def of_value(value: Any) -> List[str]:
    """Return the forms of a path, a number or another value.

    >>> of_value('/a/b.yaml')
    ['b', 'b.yaml', 'a/b', 'a/b.yaml', '/a/b', '/a/b.yaml']
    """
    if isinstance(value, str):
        return [form for path in of_path(value) for form in (os.path.splitext(path)[0], path)]
    if isinstance(value, float):
        return ['{:.{}g}'.format(value, digits) for digits in range(6, 18)]
    return [str(value), repr(value)]
