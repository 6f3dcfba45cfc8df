"""Results as plain values: what they are when they are read again, and what is refused."""
import io
import math
import pickle
from typing import Dict, List, NamedTuple, Tuple

import numpy as np
import pytest

from img_recog.batch import work_folder


class Inner(NamedTuple):
    name: str
    size: float


class Outer(NamedTuple):
    inner: List[Inner]
    counts: Dict[Inner, np.ndarray]
    pair: Tuple[int, bool]
    times: Tuple[float, ...]
    image: bytes


VALUE = Outer([Inner('a', 0.1), Inner('b', math.inf)], {Inner('c', 1 / 3): np.arange(3)},
              (1 << 60, True), (), b'\0\xff')


def test_a_value_is_the_same_again():
    found = work_folder.load_result(work_folder.dump_result(VALUE), Outer)
    assert found._replace(counts={}) == VALUE._replace(counts={})
    (key, counts), = found.counts.items()
    assert key == Inner('c', 1 / 3) and counts.dtype == int and counts.tolist() == [0, 1, 2]


def test_numbers_of_numpy_are_plain_ones():
    assert type(work_folder.load_result(work_folder.dump_result(np.int64(3)), int)) is int


@pytest.mark.parametrize('value, kind', [
    ('1', int), (1.5, int), (True, int), (None, str), ([1], Tuple[int, int]), (['a'], List[int]),
    (['a'], Inner), ([[1, 2]], Dict[str, int]), (5, np.ndarray), (1, bytes)])
def test_what_is_of_another_type(value, kind):
    with pytest.raises((TypeError, IndexError)):
        work_folder.load_result(work_folder.dump_result(value), kind)


class Trap:
    """Is called when it is unpickled."""

    called: List[str] = []

    def __reduce__(self):
        return Trap.called.append, ('x',)


def test_nothing_is_unpickled():
    array = io.BytesIO()
    np.savez(array, np.array([Trap()], object))
    for content in (pickle.dumps(Trap()), array.getvalue()):
        with pytest.raises(ValueError):
            work_folder.load_result(content, int)
    assert Trap.called == []
