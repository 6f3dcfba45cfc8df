"""Base of all settings: frozen dataclasses that check the values of their fields."""
import contextlib
import dataclasses
import math
from types import MappingProxyType
from typing import (Any, Callable, ClassVar, Iterable, Iterator, Mapping, NamedTuple, Optional,
                    Tuple, Type, TypeVar)

from img_recog.errors import UserError, shortened, suggestion


class SettingError(UserError):
    """A setting has a value of the wrong type or outside its allowed range.

    name: of the setting; value: the rejected value; got: the value as text;
    allowed: which values are allowed, as text.
    """

    def __init__(self, name: str, value: Any, allowed: str):
        got = 'nothing' if value is None else shortened(repr(value))
        super().__init__('{}: got {}, allowed is {}'.format(shortened(name), got, allowed))
        self.name = name
        self.value = value
        self.got = got
        self.allowed = allowed


class ParameterError(UserError):
    """A parameter is missing or has a value that is not allowed."""


class Allowed(NamedTuple):
    """The values that a setting accepts.

    text: describes them in error messages; accepts: returns whether a value is one of them.
    low, high: lower and upper bound, None for no bound; choices: the accepted strings, if they
    are a fixed list. is_clamped: whether a number beyond a bound becomes the bound.
    """

    text: str
    accepts: Callable[[Any], bool]
    low: Optional[float] = None
    high: Optional[float] = None
    choices: Tuple[str, ...] = ()
    is_clamped: bool = False


def at_least(low: float) -> Allowed:
    """Accept numbers greater than or equal to `low`."""
    return Allowed('at least ' + _bound(low), lambda value: value >= low, low)


def above(low: float) -> Allowed:
    """Accept numbers greater than `low`."""
    return Allowed('above ' + _bound(low), lambda value: value > low, low)


def between(low: float, high: float) -> Allowed:
    """Accept numbers from `low` to `high`, both included."""
    return Allowed('from {} to {}'.format(_bound(low), _bound(high)),
                   lambda value: low <= value <= high, low, high)


def clamped(low: int, high: int) -> Allowed:
    """Use the nearest whole number from `low` to `high`, as a node in C++ does it."""
    return between(low, high)._replace(is_clamped=True)


def _bound(value: float) -> str:
    return str(value) if isinstance(value, int) else '{:g}'.format(value)


def one_of(*choices: str) -> Allowed:
    """Accept one of the given strings."""
    return Allowed('one of ' + ', '.join(choices), lambda value: value in choices,
                   choices=choices)


def not_empty() -> Allowed:
    """Accept any string that is not empty or blank."""
    return Allowed('a non-empty string', lambda value: value.strip() != '')


def any_value() -> Allowed:
    """Accept every value of the right type."""
    return Allowed('', lambda value: True)


# The squares and products of such numbers can be computed: with 1e308, the largest one of a
# double, and its kind, the physics would compute NaN.
LARGEST, _SMALLEST = 1e30, 1e-30
MAX_INT = 0x7fffffff       # integers on the parameter server have 32 bits
_TYPE_TEXTS = {int: 'a whole number', float: 'a finite number', bool: 'true or false',
               str: 'a string'}


def setting(default: Any, allowed: Allowed = any_value(), description: str = '') -> Any:
    """Declare a field of a `Settings` class.

    default: the value if it is not overridden; only values of its type are accepted.
    allowed: which values of that type are accepted.
    description: one line, shown by dynamic_reconfigure.
    """
    return _field(default, type(default), allowed, description)


def required(value_type: type, allowed: Allowed, description: str) -> Any:
    """Declare a field of a `Settings` class that has no default and must be given.

    value_type: the type that is accepted; the other arguments as for `setting`.
    """
    return _field(None, value_type, allowed, description)


def _field(default: Any, value_type: type, allowed: Allowed,
           description: str) -> dataclasses.Field:
    return dataclasses.field(default=default, metadata={
        'kind': value_type, 'allowed': allowed, 'description': description})


@dataclasses.dataclass(frozen=True)
class Settings:
    """Base class of all settings: checks every field when an instance is created.

    is_like_roscpp: whether values are read as roscpp's getParam does it: a number is rounded for
    an int, and a value of another type leaves the default.

    Raises SettingError naming the field, its value and the allowed values.
    """

    is_like_roscpp: ClassVar[bool] = False

    def __post_init__(self):
        for field in setting_fields(type(self)):
            value = getattr(self, field.name)
            object.__setattr__(self, field.name, _checked(
                field, _as_roscpp(field, value) if self.is_like_roscpp else value))


SettingsType = TypeVar('SettingsType', bound=Settings)


def setting_fields(settings_class: type) -> Iterator[dataclasses.Field]:
    """Yield the fields of a `Settings` class that were declared by `setting` or `required`."""
    return (field for field in dataclasses.fields(settings_class) if 'allowed' in field.metadata)


def from_mapping(settings_class: Type[SettingsType], values: Mapping[str, Any]) -> SettingsType:
    """Return settings whose defaults are overridden by `values`; ignore values of other names.

    Raises SettingError naming the field, its value and the allowed values.
    """
    return settings_class(**{field.name: values[field.name]
                             for field in setting_fields(settings_class) if field.name in values})


def unknown(name: str, known: Iterable[str], full_name: str = '',
            meant: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return a message about an unknown parameter that suggests a similar name, if there is one.

    known: the names that exist; full_name: the name to show in place of `name`. meant: the names
    to suggest for those that others use.
    """
    known = sorted(known)
    advice = (suggestion(meant.get(name, name), known)
              or 'known are {}'.format(', '.join(known) or 'none'))
    return 'parameter {} is unknown to this node: {}'.format(
        shortened(full_name or name), advice)


def allowed_text(field: dataclasses.Field) -> str:
    """Return which values a field of a `Settings` class accepts, for a message."""
    value_type, allowed = field.metadata['kind'], field.metadata['allowed']
    if value_type is str:
        return allowed.text or _TYPE_TEXTS[value_type]
    return ' '.join(filter(None, (_TYPE_TEXTS[value_type], allowed.text)))


def computable(value: float) -> float:
    """Return the nearest number with which one can compute: 0, or 1e-30 to 1e30 of each sign.

    >>> computable(-1.7e308), computable(5e-324), computable(0.5)
    (-1e+30, 0.0, 0.5)
    """
    return 0.0 if abs(value) < _SMALLEST else max(-LARGEST, min(value, LARGEST))


def _as_roscpp(field: dataclasses.Field, value: Any) -> Any:
    """Return what roscpp makes of a value; a number that no int holds may be returned as it is."""
    kind = field.metadata['kind']
    if kind is int and type(value) is float and abs(value) <= MAX_INT:
        return math.floor(value) if math.fmod(value, 1.0) < 0.5 else math.ceil(value)
    is_usable = (type(value), kind) in ((kind, kind), (float, int), (int, float), (str, float))
    return value if is_usable else field.default


def _checked(field: dataclasses.Field, value: Any) -> Any:
    value_type, allowed, text = (
        field.metadata['kind'], field.metadata['allowed'], allowed_text(field))
    if allowed.is_clamped:
        # a conversion of a number that no int holds gives the lowest one on x86
        value = allowed.low if type(value) is float else max(allowed.low, min(value, allowed.high))
    if value_type is float and isinstance(value, str):
        with contextlib.suppress(ValueError):       # YAML 1.1 does not read 1e-3 as a number
            value = float(value)
    # compare types: bool is a subclass of int, and True is not a valid width
    if type(value) is int and abs(value) > MAX_INT:
        raise SettingError(field.name, value, text + ', within 32 bits')
    if value_type is float and type(value) is int:
        value = float(value)
    if value_type is int and type(value) is float and value.is_integer() and abs(
            value) <= MAX_INT:
        value = int(value)      # like roscpp
    used = computable(value) if type(value) is float and math.isfinite(value) else value
    if (type(value) is not value_type or (value_type is float and not math.isfinite(value))
            or not allowed.accepts(used)):
        raise SettingError(field.name, value, text)
    return used


def nearest_period(rate_hz: float, step_s: float) -> float:
    """Return the period in s that is nearest to a rate and a whole number of steps, min. one.

    >>> nearest_period(30.0, 0.001)
    0.033
    """
    return max(1, round(1 / rate_hz / step_s)) * step_s
