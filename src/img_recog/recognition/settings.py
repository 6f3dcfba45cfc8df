"""Which colors are looked for, and what is done when one is seen."""
import dataclasses
import re
from dataclasses import dataclass
from typing import Any, ClassVar, Iterable, Mapping, NamedTuple, Optional, Tuple, Type

from img_recog.settings import (SettingError, Settings, any_value, at_least, between, required,
                                setting)


class Color(NamedTuple):
    """A range in HSV on OpenCV's 8-bit scale (H 0-180, S and V 0-255), and what it commands.

    hue, saturation, value: lowest and highest, both inside; a hue from 170 to 10 goes through 0.
    area_limit_px: the command is given while more pixels than these are inside.
    linear_x in m/s, angular_z in rad/s: the command.
    """

    name: str
    hue: Tuple[int, int]
    saturation: Tuple[int, int]
    value: Tuple[int, int]
    area_limit_px: int
    linear_x: float
    angular_z: float

    @property
    def middle_hue(self) -> int:
        """The hue in the middle of the range, 0 to 179."""
        low, high = self.hue
        span = high - low if low <= high else high - low + _HUES
        return (low + span // 2) % _HUES


_HUES = 180        # after so many, they begin again
_HUE, _LEVEL = between(0, 180), between(0, 255)
# of each color: type, what is allowed, description
_PARTS = {
    'hue_min': (int, _HUE, 'lowest hue; above hue_max, the range goes through 0'),
    'hue_max': (int, _HUE, 'highest hue'),
    'saturation_min': (int, _LEVEL, 'lowest saturation'),
    'saturation_max': (int, _LEVEL, 'highest saturation'),
    'value_min': (int, _LEVEL, 'lowest value'),
    'value_max': (int, _LEVEL, 'highest value'),
    'area_limit': (int, at_least(0), 'the command is given above so many pixels'),
    'linear_x': (float, any_value(), 'command, m/s'),
    'angular_z': (float, any_value(), 'command, rad/s'),
}
# what holds for a color that says no more than its hue: it stops the robot
_DEFAULTS = {'saturation_min': 100, 'saturation_max': 255, 'value_min': 100, 'value_max': 255,
             'area_limit': 1000, 'linear_x': 0.0, 'angular_z': 0.0}
# the article's numbers
_KNOWN: Mapping[str, Mapping[str, Any]] = {
    'blue': {'hue_min': 50, 'hue_max': 150, 'linear_x': 10.0},
    'red': {'hue_min': 150, 'hue_max': 180, 'value_min': 150, 'linear_x': -10.0},
}
DEFAULT_COLORS = tuple(_KNOWN)          # in the order in which it looks and commands
_NAME = re.compile('[a-zA-Z][a-zA-Z0-9_]*')


@dataclass(frozen=True)
class RecognitionSettings(Settings):
    """What holds for all colors; `with_colors` makes the subclass that has those of each.

    colors: a Color for each, in the order in which they are looked for and command.
    roi_*: the region of interest in pixels (sensor_msgs/RegionOfInterest); what is outside is of
    no color. A width or height of 0 is all that there is.
    """

    publish_on_change: bool = setting(
        False, description='publish commands only when they differ from those of the last frame')
    stop_when_lost: float = setting(
        0.0, at_least(0), 'after so many seconds without a color or an image, and at the end, '
        'publish a zero Twist; 0 is never')
    min_blob_size: int = setting(
        0, at_least(0), 'connected pixels that are fewer than these do not count')
    roi_x_offset: int = setting(0, at_least(0), 'left edge of the region of interest, pixels')
    roi_y_offset: int = setting(0, at_least(0), 'upper edge of the region of interest, pixels')
    roi_width: int = setting(0, at_least(0), 'width of the region of interest, 0 is all')
    roi_height: int = setting(0, at_least(0), 'height of the region of interest, 0 is all')

    color_names: ClassVar[Tuple[str, ...]] = ()

    def __post_init__(self):
        super().__post_init__()
        for name in self.color_names:
            for part in ('saturation', 'value'):
                low, high = ('{}_{}_{}'.format(name, part, end) for end in ('min', 'max'))
                if getattr(self, low) > getattr(self, high):
                    raise SettingError(low, getattr(self, low), 'at most {}, which is {}'.format(
                        high, getattr(self, high)))

        object.__setattr__(self, 'colors', tuple(map(self._color, self.color_names)))

    def region(self, shape: Tuple[int, int]) -> Tuple[slice, slice]:
        """Return rows and columns of the region of interest, what of it is in the image.

        shape: height and width of the image in pixels.
        """
        return (_cut(self.roi_y_offset, self.roi_height, shape[0]),
                _cut(self.roi_x_offset, self.roi_width, shape[1]))

    def _color(self, name: str) -> Color:
        part = {key: getattr(self, '{}_{}'.format(name, key)) for key in _PARTS}
        return Color(name, (part['hue_min'], part['hue_max']),
                     (part['saturation_min'], part['saturation_max']),
                     (part['value_min'], part['value_max']),
                     part['area_limit'], part['linear_x'], part['angular_z'])


def with_colors(names: Iterable[str] = DEFAULT_COLORS) -> Type[RecognitionSettings]:
    """Return the settings that have hue_min, ..., angular_z of each color: blue_hue_min, ...

    Blue and red have the article's numbers as defaults; any other color must be given its
    hue_min and hue_max.
    """
    fields = [('{}_{}'.format(name, part), *_field(name, part))
              for name in names for part in _PARTS]
    return dataclasses.make_dataclass('ColorSettings', fields, bases=(RecognitionSettings,),
                                      frozen=True, namespace={'color_names': tuple(names)})


def color_in(parameter: str) -> Optional[str]:
    """Return the name of the color that a parameter is of by its own name, None if of none."""
    for part in (*_PARTS, 'image_topic'):
        if parameter.endswith('_' + part):
            return parameter[:-len(part) - 1]
    return None


def color_names(value: Any) -> Tuple[str, ...]:
    """Return the names in the parameter `colors`.

    Raises SettingError when it is anything but a list of different names.
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


def _field(name: str, part: str) -> tuple:
    kind, allowed, description = _PARTS[part]
    description = '{}: {}'.format(name, description)
    default = {**_DEFAULTS, **_KNOWN.get(name, {})}.get(part)
    if default is None:
        return kind, required(kind, allowed, description)
    return kind, setting(default, allowed, description)
