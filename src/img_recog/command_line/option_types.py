"""Types of options of a command line, for argparse."""
import argparse
import contextlib
from typing import Any, Callable


def allowed(kind: Callable[[str], Any], is_allowed: Callable[[Any], bool],
            expected: str) -> Callable[[str], Any]:
    """Return a type of which not all values are allowed.

    kind: makes a value of the text. expected: what is allowed, for the error.

    >>> allowed(float, lambda seconds: seconds > 0, 'a number above 0')('1.5')
    1.5
    """
    def value(text: str) -> Any:
        with contextlib.suppress(ValueError):
            if is_allowed(kind(text)):
                return kind(text)
        raise argparse.ArgumentTypeError('got {!r}, expected {}'.format(text, expected))
    return value
