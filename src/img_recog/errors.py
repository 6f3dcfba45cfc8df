"""The exception for problems that the user can fix, and safe texts for messages."""
import difflib
import faulthandler
import types
from typing import Any, Callable, Iterable, TypeVar

MAX_FOREIGN, MAX_LINE = 200, 2000       # characters of a text from outside, and of a whole line
_GAP = ' ... '
_STDERR = 2
Result = TypeVar('Result')


class UserError(Exception):
    """A problem that the user can fix, described in one line.

    problem: what was got and what was expected.
    advice: what to do about it; empty if the problem already says so.
    A caller that can give better advice raises a new error with the same problem.
    """

    def __init__(self, problem: str, advice: str = ''):
        super().__init__('{}; {}'.format(problem, advice) if advice else problem)
        self.problem, self.advice = problem, advice


class SimulationError(UserError):
    """A robot or a world cannot be read, built or simulated as it is given."""


def one_line(error: object) -> str:
    """Return the text of an error, or of anything else, as one line; see `shortened`.

    For an OSError this is the message of the operating system, without number and path. A
    UserError may be as long as a line, any other text as long as a text from outside.
    """
    text = getattr(error, 'strerror', None) or str(error)
    return shortened(' '.join(text.split()) or type(error).__name__,
                     MAX_LINE if isinstance(error, UserError) else MAX_FOREIGN)


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless it is 1.

    >>> counted(1, 'set of colors'), counted(0, 'frame')
    ('1 set of colors', '0 frames')
    """
    first, of, rest = noun.partition(' of ')
    return '{} {}{}{}'.format(number, first, '' if number == 1 else 's', of + rest)


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a question for the most similar of the known names, empty if none is similar.

    >>> suggestion('/cmdvel', ['/odom', '/cmd_vel'])
    'did you mean /cmd_vel?'
    """
    similar = most_similar(name, known)
    return similar and 'did you mean {}?'.format(similar)


def most_similar(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return the known name that is the most similar, empty if none is similar.

    cutoff: least similarity, from 0 to 1, as difflib computes it.
    """
    return ''.join(difflib.get_close_matches(shortened(name), sorted(known), 1, cutoff))


def shortened(value: object, limit: int = MAX_FOREIGN) -> str:
    """Return a text from outside as it may be part of a message or of a line of the log.

    Line breaks and all other characters that cannot be printed, which could forge a line or
    control the terminal, are written as in Python: `\\n`, `\\x1b`. Of a text that is longer than
    `limit` characters, only the beginning and the end remain.
    """
    text = str(value)
    if len(text) > 2 * limit:
        text = text[:limit] + text[-limit:]
    if not text.isprintable():
        text = ''.join(each if each.isprintable() else each.encode('unicode_escape').decode()
                       for each in text)
    if len(text) <= limit:
        return text
    end = limit // 4
    return text[:limit - end - len(_GAP)] + _GAP + text[-end:]


def named_in_crashes(what: str, function: Callable[..., Result], *arguments: Any) -> Result:
    """Call a function; if a library crashes in any thread meanwhile, stderr says `what`.

    A crash, like a segmentation fault, ends the process at once. Then faulthandler writes the
    calls of all threads with the names of their files, and `what` is the name of one.
    """
    faulthandler.enable(_STDERR)
    # in angle brackets: a traceback does not look for the lines of such a file
    code = _called.__code__.replace(co_filename='<{}>'.format(shortened(what)))
    return types.FunctionType(code, globals())(function, arguments)


def _called(function: Callable[..., Result], arguments: Iterable[Any]) -> Result:
    return function(*arguments)
