"""Settings of the color recognition: the colors to look for and their commands."""
import dataclasses
import functools
import re
from dataclasses import dataclass
from typing import Any, ClassVar, Dict, Iterable, List, Mapping, NamedTuple, Optional, Tuple, Type

from img_recog.settings import (Allowed, SettingError, Settings, any_value, at_least, between,
                                one_of, required, setting)


class Color(NamedTuple):
    """A color range in HSV on OpenCV's 8-bit scale (H 0-180, S and V 0-255) and its command.

    hue, saturation, value: lowest and highest value, both included; a hue range from 170 to 10
    wraps around through 0.
    area_limit_px: the command is published if more pixels than this are inside the range.
    linear_x in m/s, angular_z in rad/s: the command.
    columns, rows: the part of the image in which pixels are counted, as shares of its width from 0
    (left) to 1, and of its height from 0 (top) to 1.
    """

    name: str
    hue: Tuple[int, int]
    saturation: Tuple[int, int]
    value: Tuple[int, int]
    area_limit_px: int
    linear_x: float
    angular_z: float
    columns: Tuple[float, float] = (0.0, 1.0)
    rows: Tuple[float, float] = (0.0, 1.0)

    @property
    def middle_hue(self) -> int:
        """The hue in the middle of the range, 0 to 179.

        >>> Color('red', (170, 10), (0, 255), (0, 255), 0, 0.0, 0.0).middle_hue
        0
        """
        low, high = self.hue
        span = high - low if low <= high else high - low + _HUES
        return (low + span // 2) % _HUES


_HUES = 180        # hues wrap around here
_HUE, _LEVEL, _SHARE = between(0, 180), between(0, 255), between(0, 1)
# parameters of each color: type, allowed values, description
_PARTS: Dict[str, Tuple[type, Allowed, str]] = {
    'hue_min': (int, _HUE, 'lowest hue; if above hue_max, the range wraps around through 0'),
    'hue_max': (int, _HUE, 'highest hue'),
    'saturation_min': (int, _LEVEL, 'lowest saturation'),
    'saturation_max': (int, _LEVEL, 'highest saturation'),
    'value_min': (int, _LEVEL, 'lowest value'),
    'value_max': (int, _LEVEL, 'highest value'),
    'area_limit': (int, at_least(0), 'the command is published above this number of pixels'),
    'linear_x': (float, any_value(), 'command, m/s'),
    'angular_z': (float, any_value(), 'command, rad/s'),
    'column_min': (float, _SHARE, 'pixels left of this part of the width do not count'),
    'column_max': (float, _SHARE, 'pixels right of this part of the width do not count'),
    'row_min': (float, _SHARE, 'pixels above this part of the height do not count'),
    'row_max': (float, _SHARE, 'pixels below this part of the height do not count'),
}
# defaults of any other color: its command stops the robot
_DEFAULTS: Mapping[str, Any] = {
    'saturation_min': 100, 'saturation_max': 255, 'value_min': 100, 'value_max': 255,
    'area_limit': 1000, 'linear_x': 0.0, 'angular_z': 0.0, 'column_min': 0.0, 'column_max': 1.0,
    'row_min': 0.0, 'row_max': 1.0}
# the article's numbers
_ARTICLE_COLORS: Mapping[str, Mapping[str, Any]] = {
    'blue': {'hue_min': 50, 'hue_max': 150, 'linear_x': 10.0},
    'red': {'hue_min': 150, 'hue_max': 180, 'value_min': 150, 'linear_x': -10.0},
}
DEFAULT_COLORS = tuple(_ARTICLE_COLORS)      # in the order of their commands
_NAME = re.compile('[a-zA-Z][a-zA-Z0-9_]*')
ALL, LAST, SUM = 'all', 'last', 'sum'        # of the commands of an image: what is published


@dataclass(frozen=True)
class RecognitionSettings(Settings):
    """Settings that apply to all colors; `with_colors` adds those of each color.

    roi_*: the region of interest in pixels (sensor_msgs/RegionOfInterest); pixels outside of it
    are not counted. A width or height of 0 means up to the edge of the image.
    """

    publish_commands: str = setting(
        ALL, one_of(ALL, LAST, SUM), 'what is published for an image: the command of each color '
        'above its limit, or one, the last of them or their sum')
    publish_on_change: bool = setting(
        False, description='publish commands only when they differ from those of the last frame')
    stop_when_lost: float = setting(
        0.0, at_least(0), 'publish a zero Twist after this many seconds without a color or an '
        'image, and on shutdown; 0: never')
    min_blob_size: int = setting(
        0, at_least(0), 'ignore groups of fewer connected pixels than this')
    roi_x_offset: int = setting(0, at_least(0), 'left edge of the region of interest, pixels')
    roi_y_offset: int = setting(0, at_least(0), 'upper edge of the region of interest, pixels')
    roi_width: int = setting(
        0, at_least(0), 'width of the region of interest, pixels; 0: up to the right edge')
    roi_height: int = setting(
        0, at_least(0), 'height of the region of interest, pixels; 0: up to the lower edge')

    color_names: ClassVar[Tuple[str, ...]] = ()

    def __post_init__(self):
        super().__post_init__()
        for name in self.color_names:
            for part in ('saturation', 'value', 'column', 'row'):
                low, high = ('{}_{}_{}'.format(name, part, end) for end in ('min', 'max'))
                if getattr(self, low) > getattr(self, high):
                    raise SettingError(low, getattr(self, low), 'at most {}, which is {}'.format(
                        high, getattr(self, high)))

    @functools.cached_property
    def colors(self) -> Tuple[Color, ...]:
        """The colors, in the order of their commands."""
        return tuple(map(self._color, self.color_names))

    def region(self, shape: Tuple[int, int]) -> Tuple[slice, slice]:
        """Return the rows and columns of the image that are in the region of interest.

        shape: height and width of the image in pixels.

        >>> RecognitionSettings(roi_x_offset=600, roi_width=100).region((480, 640))
        (slice(0, 480, None), slice(600, 640, None))
        """
        return (_cut(self.roi_y_offset, self.roi_height, shape[0]),
                _cut(self.roi_x_offset, self.roi_width, shape[1]))

    def _color(self, name: str) -> Color:
        values = {part: getattr(self, '{}_{}'.format(name, part)) for part in _PARTS}
        return Color(name, (values['hue_min'], values['hue_max']),
                     (values['saturation_min'], values['saturation_max']),
                     (values['value_min'], values['value_max']),
                     values['area_limit'], values['linear_x'], values['angular_z'],
                     (values['column_min'], values['column_max']),
                     (values['row_min'], values['row_max']))


def with_colors(names: Iterable[str] = DEFAULT_COLORS) -> Type[RecognitionSettings]:
    """Return a settings class with the fields of each color: blue_hue_min ... blue_angular_z.

    Blue and red have the article's values as defaults; for any other color, hue_min and hue_max
    are required.
    """
    fields: List[Tuple[str, type, Any]] = [
        ('{}_{}'.format(name, part), _PARTS[part][0], _field(name, part))
        for name in names for part in _PARTS]
    return dataclasses.make_dataclass('ColorSettings', fields, bases=(RecognitionSettings,),
                                      frozen=True, namespace={'color_names': tuple(names)})


def color_in(parameter: str) -> Optional[str]:
    """Return the name of the color that a parameter is named after, None if there is none.

    >>> color_in('light_blue_hue_min')
    'light_blue'
    """
    for part in (*_PARTS, 'image_topic'):
        if parameter.endswith('_' + part):
            return parameter[:-len(part) - 1]
    return None


def color_names(value: Any) -> Tuple[str, ...]:
    """Return the value of the parameter `colors` as a tuple.

    Raises SettingError if it is not a list of different names.

    >>> color_names(['blue', 'red'])
    ('blue', 'red')
    """
    if (isinstance(value, (list, tuple)) and value
            and all(isinstance(name, str) and _NAME.fullmatch(name) for name in value)
            and len(set(value)) == len(value)):
        return tuple(value)
    raise SettingError('colors', value, 'a list of one or more different names (a letter, then '
                       'letters, digits and _), like [blue, red]')


def _cut(offset: int, length: int, whole: int) -> slice:
    start = min(offset, whole)
    return slice(start, min(start + length, whole) if length else whole)


def _field(name: str, part: str) -> Any:
    value_type, allowed, description = _PARTS[part]
    description = '{}: {}'.format(name, description)
    defaults: Dict[str, Any] = {**_DEFAULTS, **_ARTICLE_COLORS.get(name, {})}
    default = defaults.get(part)
    if default is None:
        return required(value_type, allowed, description)
    return setting(default, allowed, description)
