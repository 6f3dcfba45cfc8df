"""Reads the file of a sweep: which runs there are, and what counts as success."""
import dataclasses
import itertools
import math
import os
import random
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple, Union

from img_recog.batch.recorded import of_value, unique
from img_recog.errors import UserError, one_line, shortened, suggestion
from img_recog.formats.markup import MarkupError
from img_recog.formats.yaml_text import read_yaml
from img_recog.loading import resources
from img_recog.rendering.light import LightSettings
from img_recog.settings import (SettingError, Settings, above, at_least, between, from_mapping,
                                not_empty, setting, setting_fields)
from img_recog.simulation.simulation_settings import CameraSettings, DriveSettings, SpawnSettings

_MAX_RUNS = 10 ** 6
_PARAMETERS, _CELLS, _SUCCESS, _FROM, _TO = 'parameters', 'cells', 'success', 'from', 'to'
_PATHS = 'world', 'urdf', 'colors'
_EMPTY_WORLD = 'empty'


@dataclass(frozen=True)
class SweepSettings(Settings):
    """runs: of each combination. seed: of all draws and of the noise. time_limit: s of a run."""

    runs: int = setting(1, between(1, 10 ** 9))
    seed: int = setting(0, at_least(0))
    time_limit: float = setting(60.0, above(0))


@dataclass(frozen=True)
class Success(Settings):
    """What a run has to do within its time limit.

    distance: m, between the middle of the robot and that of the nearest goal, from above.
    collisions: how often the robot may touch something from the side. path_length: m that it may
    drive; 0 is any.
    """

    distance: float = setting(0.5, above(0))
    collisions: int = setting(0, at_least(0))
    path_length: float = setting(0.0, at_least(0))


@dataclass(frozen=True)
class _Others(Settings):
    """goal: name of models, with * for any characters. teleop: whether the idle one sends."""

    world: str = setting(resources.DEFAULT_WORLD)
    urdf: str = setting('')
    colors: str = setting('')
    goal: str = setting('*', not_empty())
    teleop: bool = setting(False)


# of the parameters of a run
KINDS = (_Others, SpawnSettings, DriveSettings, CameraSettings, LightSettings)
_KIND_OF = {field.name: kind for kind in KINDS for field in setting_fields(kind)}


class Range(NamedTuple):
    """Values of which each run draws one, all as likely."""

    low: float
    high: float


Values = Dict[str, Any]


class Choice(NamedTuple):
    """Parameters of which the sweep has each group of values; groups: by their labels."""

    name: str
    groups: Dict[str, Values]


class Run(NamedTuple):
    """A closed loop. seed: of its noise; parameters: all that the file gives, by name."""

    key: str
    labels: Dict[str, str]
    seed: int
    parameters: Values


class Sweep(NamedTuple):
    """What the file says. cells: names of the choices that the table of the result has."""

    settings: SweepSettings
    success: Success
    fixed: Values
    choices: Tuple[Choice, ...]
    cells: Tuple[str, ...]

    @property
    def size(self) -> int:
        """How many runs there are."""
        return self.settings.runs * math.prod(len(choice.groups) for choice in self.choices)

    def runs(self) -> Iterator[Run]:
        """Yield all runs. What a run draws depends on the seed and its key alone."""
        for labels in itertools.product(*(choice.groups for choice in self.choices)):
            name = ','.join('{}={}'.format(choice.name, label)
                            for choice, label in zip(self.choices, labels))
            values: Values = dict(self.fixed)
            for choice, label in zip(self.choices, labels):
                values.update(choice.groups[label])
            for number in range(1, self.settings.runs + 1):
                key = '{}#{}'.format(name or 'run', number)
                draw = random.Random('{} {}'.format(self.settings.seed, key))
                seed = draw.getrandbits(31)
                yield Run(key, {choice.name: label for choice, label in zip(self.choices, labels)},
                          seed, {each: draw.uniform(*value) if isinstance(value, Range) else value
                                 for each, value in sorted(values.items())})


def read(path: str) -> Sweep:
    """Return what a file says; raise UserError, with the place in it, if that is not possible."""
    try:
        content = read_yaml(path)
    except (OSError, MarkupError) as error:
        raise UserError('cannot read the sweep {}: {}'.format(path, one_line(error)))
    if not isinstance(content, dict) or not isinstance(content.get(_PARAMETERS), dict):
        raise UserError('{}: expected a line "{}:", and below it lines like x_pos: -2'.format(
            path, _PARAMETERS))
    names = [field.name for field in setting_fields(SweepSettings)]
    _refuse_unknown(path, content, [*names, _PARAMETERS, _SUCCESS, _CELLS])
    success = content.get(_SUCCESS) or {}
    if not isinstance(success, dict):
        raise UserError('{}: {}: expected lines like distance: 0.5'.format(path, _SUCCESS))
    _refuse_unknown('{}: {}'.format(path, _SUCCESS), success,
                    [field.name for field in setting_fields(Success)])
    try:
        settings, wanted = from_mapping(SweepSettings, content), from_mapping(Success, success)
    except SettingError as error:
        raise UserError('{}: {}'.format(path, error.problem))
    fixed, choices = _parameters(path, content[_PARAMETERS])
    sweep = Sweep(settings, wanted, fixed, choices, _cells(path, content.get(_CELLS), choices))
    if sweep.size > _MAX_RUNS:
        raise UserError('{}: {} runs, allowed are {}'.format(path, sweep.size, _MAX_RUNS),
                        'set runs to less, or give fewer values')
    return sweep


def _parameters(path: str, content: Mapping[Any, Any]) -> Tuple[Values, Tuple[Choice, ...]]:
    fixed: Values = {}
    choices: List[Choice] = []
    for name, value in content.items():
        if isinstance(value, dict) and set(value) != {_FROM, _TO}:
            choices.append(_choice(str(name), [[str(label), repr(label)] for label in value], [
                _group(path, '{}: {}'.format(name, label), group)
                for label, group in value.items()]))
        elif isinstance(value, list):
            values = [_value(path, name, each) for each in value]
            _refuse_twice('{}: {}'.format(path, name), values)
            choices.append(_choice(name, list(map(of_value, values)),
                                   [{name: each} for each in values]))
        else:
            fixed[name] = _value(path, name, value)
    for choice in choices:
        if not choice.groups:
            raise UserError('{}: {}: expected one value at least'.format(path, choice.name))
    names = [*fixed, *(name for choice in choices
                       for name in set().union(*choice.groups.values()))]
    _refuse_twice(path, names)
    _refuse_twice(path, list(map(str, content)))
    if 'goal' not in names:
        raise UserError('{}: {}: there is no goal'.format(path, _PARAMETERS),
                        'add one, like goal: blue_post*')
    return fixed, tuple(choices)


def _choice(name: str, forms: Sequence[Sequence[str]], groups: Sequence[Values]) -> Choice:
    # what separates labels in a key is no part of one
    return Choice(name, dict(zip((repr(label) if set(label) & set(',=#') else label
                                  for label in unique(forms)), groups)))


def _refuse_twice(place: str, values: Sequence[Any]) -> None:
    for value in values:
        if values.count(value) > 1:
            raise UserError('{}: {} is given twice'.format(place, value))


def _group(path: str, place: str, group: Any) -> Values:
    if not isinstance(group, dict):
        raise UserError('{}: {}: expected lines like x_pos: -2'.format(path, place))
    return {name: _value(path, name, value) for name, value in group.items()}


def _value(path: str, name: Any, value: Any) -> Any:
    """Return a value that was checked; a relative path begins in the folder of the file."""
    _refuse_unknown(path, [name], _KIND_OF)
    if isinstance(value, dict) and set(value) == {_FROM, _TO}:
        ends = Range(*(_value(path, name, value[end]) for end in (_FROM, _TO)))
        if not all(isinstance(end, float) for end in ends) or ends.low > ends.high:
            raise UserError('{}: {}: expected two numbers, the lower one first'.format(path, name))
        return ends
    try:
        value = getattr(_KIND_OF[name](**{name: value}), name)
    except SettingError as error:
        raise UserError('{}: {}'.format(path, error.problem))
    return _file(path, name, value) if name in _PATHS and value else value


def _file(path: str, name: str, value: str) -> str:
    """Return the path of a file, or the name of a world."""
    worlds = [_EMPTY_WORLD, *resources.worlds()]
    if name == 'world' and value in worlds:
        return value
    found = os.path.join(os.path.dirname(os.path.abspath(path)), os.path.expanduser(value))
    if not os.path.isfile(found):
        raise UserError('{}: {}: no file {}'.format(path, name, found), '' if name != 'world' else
                        suggestion(value, worlds) or 'known worlds are ' + ', '.join(worlds))
    return os.path.normpath(found)


def _cells(path: str, names: Any, choices: Sequence[Choice]) -> Tuple[str, ...]:
    known = [choice.name for choice in choices]
    if names is None:
        return tuple(known[:2])
    if not isinstance(names, list) or len(names) > 2:
        raise UserError('{}: {}: expected a list of one or two of: {}'.format(
            path, _CELLS, ', '.join(known) or 'nothing, as no parameter has several values'))
    _refuse_unknown('{}: {}'.format(path, _CELLS), names, known)
    return tuple(names)


def _refuse_unknown(place: str, names: Union[Mapping[Any, Any], Sequence[Any]],
                    known: Union[Mapping[str, Any], Sequence[str]]) -> None:
    for name in names:
        if name not in known:
            raise UserError('{}: unknown is {}'.format(place, shortened(name)),
                            suggestion(str(name), known) or 'known are ' + ', '.join(known))


def given(kind: Any, parameters: Values) -> Values:
    """Return the parameters that belong to a class of settings."""
    names = {field.name for field in dataclasses.fields(kind)}
    return {name: value for name, value in parameters.items() if name in names}
