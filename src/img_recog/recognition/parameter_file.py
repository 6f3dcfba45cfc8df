"""A YAML file with the parameters of the recognition, read and checked."""
from typing import Any, Mapping, Sequence

import yaml

from img_recog.recognition.settings import (DEFAULT_COLORS, RecognitionSettings, color_in,
                                            color_names, with_colors)
from img_recog.settings import ParameterError, SettingError, from_mapping, setting_fields, unknown

COLORS = 'colors'
IMAGE_TOPIC = '{}_image_topic'
# parameters of the node that do not matter without it
_NODE_ONLY = ('colors_file', 'image_transport')


def read(path: str) -> RecognitionSettings:
    """Return the settings in a YAML file as the node's parameters are loaded from.

    Raises ParameterError naming file, parameter, value and what is allowed.
    """
    values = _mapping(path)
    try:
        names = color_names(values.pop(COLORS, list(DEFAULT_COLORS)))
        kind = with_colors(names)
        known = {field.name for field in setting_fields(kind)}
        others = {*_NODE_ONLY, *(IMAGE_TOPIC.format(name) for name in names)}
        for name in values:
            if color_in(name) not in (None, *names):
                raise ParameterError('{}: parameter {}: {}'.format(
                    path, name, no_such_color(name, names)))
            if name not in known | others:
                raise ParameterError('{}: {}'.format(path, unknown(name, known)))
        return from_mapping(kind, values)
    except SettingError as error:
        raise ParameterError('{}: parameter {}: got {}, allowed is {}'.format(
            path, error.name, error.got, error.allowed))


def no_such_color(parameter: str, names: Sequence[str]) -> str:
    """Return the line about a parameter of a color that is not among the names."""
    name = color_in(parameter)
    return 'there is no color {}, the colors are {}; add it to {}: [{}]'.format(
        name, ', '.join(names), COLORS, ', '.join([*names, name]))


def _mapping(path: str) -> Mapping[str, Any]:
    try:
        with open(path) as file:
            values = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError('cannot read the parameters in {}: {}'.format(
            path, ' '.join(str(getattr(error, 'strerror', None) or error).split())))
    if not isinstance(values, dict) or not values:
        raise ParameterError('cannot use the parameters in {}: got {}, wants lines like '
                             'colors: [blue, red] and blue_hue_min: 50'.format(
                                 path, 'nothing' if not values else type(values).__name__))
    for name in values:
        if not isinstance(name, str):
            raise ParameterError('{}: got {!r} in the place of the name of a parameter'.format(
                path, name))
    return values
