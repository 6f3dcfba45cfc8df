"""A YAML file with the parameters of the color recognition."""
import os
import reprlib
from typing import Any, Dict, List, NamedTuple, Sequence

from img_recog.errors import one_line, shortened, suggestion
from img_recog.formats.markup import MarkupError
from img_recog.formats.yaml_text import read_yaml
from img_recog.recognition.recognition_settings import (DEFAULT_COLORS, RecognitionSettings,
                                                        color_in, color_names, with_colors)
from img_recog.settings import ParameterError, SettingError, from_mapping, setting_fields, unknown

COLORS, COLORS_FILE = 'colors', 'colors_file'
IMAGE_TOPIC = '{}_image_topic'
_MAX_LENGTH = 1000      # of a name or text
_MAX_SHOWN = 50         # characters of a name in an error
_ADVICE = 'give a parameter file of color_extract, like config/colors.yaml'
# parameters of the node color_extract that do not affect the recognition itself
_NODE_ONLY = (COLORS_FILE, 'image_transport', 'max_image_pixels')


class ParameterFile(NamedTuple):
    """The parameters in a file, by their names, and the settings that they are."""

    values: Dict[str, Any]
    settings: RecognitionSettings


def load(path: str) -> ParameterFile:
    """Return what a YAML file with parameters of color_extract holds.

    Raises ParameterError naming the file, the parameter, its value and the allowed values.
    """
    values = _values_in(path)
    return ParameterFile(values, settings_in(values, path))


def read(path: str) -> RecognitionSettings:
    """Return the settings in a file; see `load`."""
    return load(path).settings


def read_or_default(path: str) -> RecognitionSettings:
    """Return the settings in a file that a user names; if empty, those of the article.

    Raises ParameterError, as `load` does.
    """
    return read(os.path.expanduser(path)) if path else with_colors()()


def settings_in(values: Dict[str, Any], path: str) -> RecognitionSettings:
    """Return the settings in the parameters of color_extract; path: their place in messages.

    Raises ParameterError, as `load` does.
    """
    try:
        values = dict(values)
        names = color_names(values.pop(COLORS, list(DEFAULT_COLORS)))
        settings_class = with_colors(names)
        known = {field.name for field in setting_fields(settings_class)}
        others = set(node_only(names))
        for name in values:
            color = color_in(name)
            if color is not None and color not in names:
                raise ParameterError('{}: parameter {}: {}'.format(
                    path, shortened(name, _MAX_SHOWN), unknown_color(color, names)))
            if name not in known | others:
                raise ParameterError('{}: {}'.format(
                    path, unknown(name, {COLORS} | known | others)))
        return from_mapping(settings_class, values)
    except SettingError as error:
        raise ParameterError('{}: parameter {}: got {}, allowed is {}'.format(
            path, error.name, error.got, error.allowed))


def node_only(names: Sequence[str]) -> List[str]:
    """Return the parameters of a node with these colors that are no settings of the recognition.
    """
    return [*_NODE_ONLY, *(IMAGE_TOPIC.format(name) for name in names)]


def unknown_color(color: str, names: Sequence[str]) -> str:
    """Return a message about a parameter of a color that is not in the parameter `colors`."""
    color, similar = shortened(color, _MAX_SHOWN), suggestion(color, names)
    return 'there is no color {}, the colors are {}; {}add it to {}: [{}]'.format(
        color, ', '.join(names), similar and similar + ' Or ', COLORS, ', '.join([*names, color]))


def _values_in(path: str) -> Dict[str, Any]:
    """Return the parameters in a YAML file, unchecked; raise ParameterError, as `load` does."""
    try:
        values = read_yaml(path)
    except (OSError, MarkupError) as error:
        raise ParameterError('cannot read the parameters in {}: {}'.format(path, one_line(error)),
                             _ADVICE)
    if not isinstance(values, dict) or not values:
        raise ParameterError('cannot use the parameters in {}: got {}, expected lines like '
                             'colors: [blue, red] and blue_hue_min: 50'.format(
                                 path, 'nothing' if not values else type(values).__name__))
    for name, value in values.items():
        if not isinstance(name, str) or len(name) > _MAX_LENGTH:
            raise ParameterError('{}: got {} where the name of a parameter is expected'.format(
                path, reprlib.repr(name)))
        # not printed whole: aliases can make a few lines a tree of any size
        parts = value if isinstance(value, list) else [value]
        if not all(map(_is_simple, parts)):
            raise ParameterError('{}: parameter {}: got {}, allowed is one value or a list of '
                                 'names'.format(path, name, reprlib.repr(value)))
    return values


def _is_simple(value: Any) -> bool:
    if isinstance(value, str):
        return len(value) <= _MAX_LENGTH
    if isinstance(value, int):
        return abs(value) < 10 ** _MAX_LENGTH
    return value is None or isinstance(value, float)
