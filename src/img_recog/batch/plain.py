"""Results as bytes that are values alone, JSON and arrays: reading a pickle would run code."""
import functools
import io
import json
from typing import Any, List, Tuple, get_args, get_origin, get_type_hints

import numpy as np

_hints = functools.lru_cache(maxsize=None)(get_type_hints)


def dump(value: Any) -> bytes:
    """Return an npz of a value: of named tuples, lists, dicts, arrays, bytes and what JSON has.

    Its first array is the JSON, in which numbers stand for the others.
    """
    arrays: List[np.ndarray] = []
    text = json.dumps(_with_numbers(value, arrays)).encode()
    file = io.BytesIO()
    np.savez(file, np.frombuffer(text, np.uint8), *arrays)
    return file.getvalue()


def load(content: bytes, kind: Any) -> Any:
    """Return a value of a type, which names those of all its parts, as `dump` was given it.

    Raises errors of many types if that is not what the content is.
    """
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = [file[name] for name in file.files]
    return _of_kind(json.loads(arrays[0].tobytes().decode()), kind, arrays)


def _with_numbers(value: Any, arrays: List[np.ndarray]) -> Any:
    """Return a value with lists for all that has parts, and numbers for arrays."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (np.ndarray, bytes)):
        arrays.append(np.frombuffer(value, np.uint8) if isinstance(value, bytes) else value)
        return len(arrays)
    parts = list(value.items()) if isinstance(value, dict) else value
    return [_with_numbers(each, arrays) for each in parts] if isinstance(
        parts, (list, tuple)) else value


def _of_kind(value: Any, kind: Any, arrays: List[np.ndarray]) -> Any:
    """Return what `_with_numbers` was given; TypeError if it is of another type."""
    origin, kinds = get_origin(kind), get_args(kind)
    if kind in (np.ndarray, bytes):
        return arrays[value] if kind is np.ndarray else arrays[value].tobytes()
    if origin is dict:
        return dict(_of_kind(each, Tuple[kinds], arrays) for each in value)
    if origin is list or origin is tuple and kinds[-1] is ...:
        return origin(_of_kind(each, kinds[0], arrays) for each in value)
    if hasattr(kind, '_fields'):
        kinds = tuple(_hints(kind)[name] for name in kind._fields)
    if kinds:
        if len(value) != len(kinds):
            raise TypeError('{} parts, expected {}'.format(len(value), len(kinds)))
        parts = [_of_kind(*each, arrays) for each in zip(value, kinds)]
        return tuple(parts) if origin is tuple else kind(*parts)
    if type(value) is not kind and (kind is not float or type(value) is not int):
        raise TypeError('{} is no {}'.format(value, kind))
    return value
