"""A YAML file with the parameters of the color recognition."""
from typing import Any, Dict, Sequence

import yaml

from img_recog.errors import one_line, shortened
from img_recog.recognition.settings import (DEFAULT_COLORS, RecognitionSettings, color_in,
                                            color_names, with_colors)
from img_recog.settings import ParameterError, SettingError, from_mapping, setting_fields, unknown

COLORS = 'colors'
IMAGE_TOPIC = '{}_image_topic'
# parameters of the node color_extract that do not affect the recognition itself
_NODE_ONLY = ('colors_file', 'image_transport', 'max_image_pixels')


def read(path: str) -> RecognitionSettings:
    """Return the settings in a YAML file with parameters of color_extract.

    Raises ParameterError naming the file, the parameter, its value and the allowed values.
    """
    values = _mapping(path)
    try:
        names = color_names(values.pop(COLORS, list(DEFAULT_COLORS)))
        settings_class = with_colors(names)
        known = {field.name for field in setting_fields(settings_class)}
        others = {*_NODE_ONLY, *(IMAGE_TOPIC.format(name) for name in names)}
        for name in values:
            color = color_in(name)
            if color is not None and color not in names:
                raise ParameterError('{}: parameter {}: {}'.format(
                    path, name, unknown_color(color, names)))
            if name not in known | others:
                raise ParameterError('{}: {}'.format(path, unknown(name, known)))
        return from_mapping(settings_class, values)
    except SettingError as error:
        raise ParameterError('{}: parameter {}: got {}, allowed is {}'.format(
            path, error.name, error.got, error.allowed))


def unknown_color(color: str, names: Sequence[str]) -> str:
    """Return a message about a parameter of a color that is not in the parameter `colors`."""
    color = shortened(color)
    return 'there is no color {}, the colors are {}; add it to {}: [{}]'.format(
        color, ', '.join(names), COLORS, ', '.join([*names, color]))


def _mapping(path: str) -> Dict[str, Any]:
    try:
        with open(path) as file:
            values = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError('cannot read the parameters in {}: {}'.format(path, one_line(error)))
    if not isinstance(values, dict) or not values:
        raise ParameterError('cannot use the parameters in {}: got {}, expected lines like '
                             'colors: [blue, red] and blue_hue_min: 50'.format(
                                 path, 'nothing' if not values else type(values).__name__))
    for name in values:
        if not isinstance(name, str):
            raise ParameterError('{}: got {!r} where the name of a parameter is expected'.format(
                path, name))
    return values
