"""Frozen dataclasses whose fields know which values they allow."""
import dataclasses
import difflib
import math
from typing import (Any, Callable, Iterable, Iterator, Mapping, NamedTuple, Optional, Tuple, Type,
                    TypeVar)

from img_recog.errors import UserError


class SettingError(UserError):
    """A setting has a value of the wrong type or outside what is allowed."""

    def __init__(self, name: str, value: Any, allowed: str):
        got = 'nothing' if value is None else repr(value)
        super().__init__('{}: got {}, allowed is {}'.format(name, got, allowed))
        self.name = name
        self.value = value
        self.got = got
        self.allowed = allowed


class ParameterError(UserError):
    """A parameter is missing or has a value that is not allowed."""


class Allowed(NamedTuple):
    """What a setting accepts: words for the error line and the test behind them.

    low, high: no number outside of them is accepted; choices: the words that are, where counted.
    """

    text: str
    accepts: Callable[[Any], bool]
    low: Optional[float] = None
    high: Optional[float] = None
    choices: Tuple[str, ...] = ()


def at_least(low: float) -> Allowed:
    """Accept numbers from `low` upwards."""
    return Allowed('at least {:g}'.format(low), lambda value: value >= low, low)


def above(low: float) -> Allowed:
    """Accept numbers greater than `low`."""
    return Allowed('above {:g}'.format(low), lambda value: value > low, low)


def between(low: float, high: float) -> Allowed:
    """Accept numbers from `low` to `high`, both included."""
    return Allowed('from {:g} to {:g}'.format(low, high), lambda value: low <= value <= high,
                   low, high)


def one_of(*choices: str) -> Allowed:
    """Accept one of the given words."""
    return Allowed('one of ' + ', '.join(choices), lambda value: value in choices,
                   choices=choices)


def not_empty() -> Allowed:
    """Accept any text but the empty one."""
    return Allowed('a text that is not empty', lambda value: value.strip() != '')


def any_value() -> Allowed:
    """Accept every value of the right type."""
    return Allowed('', lambda value: True)


_MOST = 0x7fffffff      # parameters are whole numbers of 32 bits
_KINDS = {int: 'a whole number', float: 'a finite number', bool: 'true or false', str: 'a text'}


def setting(default: Any, allowed: Allowed = any_value(), description: str = '') -> Any:
    """Declare a field of a `Settings` class.

    default: the value in force unless it is overridden; its type is the type that is accepted.
    allowed: which values of that type are accepted.
    description: one line for those who change the setting while the node runs.
    """
    return _field(default, type(default), allowed, description)


def required(kind: type, allowed: Allowed = any_value(), description: str = '') -> Any:
    """Declare a field of a `Settings` class that has no default: it has to be given.

    kind: the type that is accepted; the others as for `setting`.
    """
    return _field(None, kind, allowed, description)


def _field(default: Any, kind: type, allowed: Allowed, description: str) -> dataclasses.Field:
    return dataclasses.field(default=default, metadata={
        'kind': kind, 'allowed': allowed, 'description': description})


@dataclasses.dataclass(frozen=True)
class Settings:
    """Base of all settings: checks every field when an instance is made.

    Raises SettingError naming the field, its value and what is allowed.
    """

    def __post_init__(self):
        for field in setting_fields(type(self)):
            object.__setattr__(self, field.name, _checked(field, getattr(self, field.name)))


SettingsType = TypeVar('SettingsType', bound=Settings)


def setting_fields(settings_class: type) -> Iterator[dataclasses.Field]:
    """Yield the fields of a `Settings` class that were made by `setting`."""
    return (field for field in dataclasses.fields(settings_class) if 'allowed' in field.metadata)


def from_mapping(settings_class: Type[SettingsType], values: Mapping[str, Any]) -> SettingsType:
    """Return the settings with those of `values` that are theirs in the place of defaults.

    Raises SettingError naming the field, its value and what is allowed.
    """
    return settings_class(**{field.name: values[field.name]
                             for field in setting_fields(settings_class) if field.name in values})


def unknown(name: str, known: Iterable[str], full_name: str = '') -> str:
    """Return the line that says that there is no such parameter, and which is meant perhaps."""
    near = difflib.get_close_matches(name, sorted(known), 1)
    advice = ('did you mean {}?'.format(near[0]) if near else
              'known are {}'.format(', '.join(sorted(known)) or 'none'))
    return 'parameter {} is not one of this node: {}'.format(full_name or name, advice)


def _number(text: str) -> Any:
    """Return the float in a text like 1e-3, which YAML 1.1 takes for no number, else the text."""
    try:
        return float(text)
    except ValueError:
        return text


def _checked(field: dataclasses.Field, value: Any) -> Any:
    kind, allowed = field.metadata['kind'], field.metadata['allowed']
    words = ' '.join(filter(None, (_KINDS[kind], allowed.text)))
    if kind is str:
        words = allowed.text or _KINDS[kind]
    if kind is float and isinstance(value, str):
        value = _number(value)
    # bool is a subclass of int, so a plain isinstance would take True for a width of 1
    if type(value) is int and abs(value) > _MOST:
        raise SettingError(field.name, value, words + ', of 32 bits')
    if kind is float and type(value) is int:
        value = float(value)
    if kind is int and type(value) is float and value.is_integer() and abs(value) <= _MOST:
        value = int(value)      # as roscpp takes it
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        raise SettingError(field.name, value, words)
    if not allowed.accepts(value):
        raise SettingError(field.name, value, words)
    return value
