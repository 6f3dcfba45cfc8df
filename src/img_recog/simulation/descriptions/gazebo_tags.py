"""The settings that the <gazebo> tags of a URDF give for the drive and the sensors.

drive_tags.py has the rows of drives, camera_tags.py reads those of cameras, description.py
friction. The rows of each kind of sensors are beside its class, as `Tags`.
"""
import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Set, Union

from img_recog.simulation.descriptions import camera_tags
from img_recog.simulation.descriptions.description import root_of
from img_recog.simulation.settings import SimulationError, nearest_period

Values = Dict[str, Union[str, float, int, bool]]


class Reader(NamedTuple):
    """How a text is read.

    read: raises ValueError or KeyError; returns None for a value that leaves the setting alone.
    """

    expected: str
    read: Callable[[str], Any]


class Row(NamedTuple):
    """Where the value of a setting is found.

    owner: 'plugin' or 'sensor', the element that `path` starts from; other_path: where to look
    when there is nothing at `path`.
    """

    setting: str
    reader: Reader
    owner: str
    path: str
    other_path: Optional[str] = None


class Tags(NamedTuple):
    """Where the settings of the drive or of a kind of sensors are.

    plugins: parts of the file names of its plugins. rows: of two for a setting, the later one
    counts. sensors: the types of <sensor> that such a plugin can be in; frame: the setting that
    is the link of that, unless a row has it. needs_sensor: whether the plugin must be in one,
    which then measures without a plugin too; else one without the plugin publishes nothing.
    """

    plugins: Sequence[str]
    rows: Sequence[Row]
    sensors: Sequence[str] = ()
    frame: str = ''
    needs_sensor: bool = False


class Found(NamedTuple):
    """What is in <gazebo> tags.

    values: the settings that they give, by name: SI units, and periods that are whole steps.
    not_simulated: the plugins and sensors that are not simulated, in their order. Each is 'plugin
    FILENAME' or 'sensor TYPE', after the word 'second' where it is a duplicate. Those of cameras
    are not among them.
    """

    values: Values
    not_simulated: List[str]


def read(urdf: str, step_s: float, readers: Sequence[Tags]) -> Found:
    """Return what the <gazebo> tags of a URDF's text give.

    step_s: of the physics. Settings without a tag are absent. Leading slashes of names are
    removed. Of two drives or two sensors of a kind, the first counts.
    Raises SimulationError when `urdf` is not a URDF or a value cannot be read.
    """
    found = Found({}, [])
    known: Set[int] = set()         # numbers of readers that have read a part
    for part in _parts(root_of(urdf), readers):
        first = [number for number in part.readers if number not in known]
        for number in first:
            found.values.update(_values_in(part, readers[number], step_s))
        if not first:
            found.not_simulated.append('second ' * bool(part.readers) + part.label)
        known.update(first)
    return found


class _Part(NamedTuple):
    """A plugin or a sensor with its plugin; readers: the numbers of those that read it."""

    readers: Sequence[int]
    label: str
    link: Optional[str]
    sensor: Optional[ElementTree.Element]
    plugin: Optional[ElementTree.Element]


def _parts(robot: ElementTree.Element, readers: Sequence[Tags]) -> Iterator[_Part]:
    for tag in robot.findall('gazebo'):
        link = tag.get('reference')
        for plugin in tag.findall('plugin'):
            of_plugin = [number for number, tags in enumerate(readers)
                         if not tags.needs_sensor and is_of(plugin, tags)]
            yield _Part(of_plugin, _label(plugin, 'filename'), link, None, plugin)
        for sensor in tag.findall('sensor'):
            yield from _sensor_parts(sensor, link, readers)


def _sensor_parts(sensor: ElementTree.Element, link: Optional[str],
                  readers: Sequence[Tags]) -> Iterator[_Part]:
    plugins = sensor.findall('plugin')
    camera = camera_tags.plugin_of(sensor)
    if camera is not None:
        for plugin in plugins:
            if plugin is not camera:
                yield _Part((), _label(plugin, 'filename'), link, sensor, plugin)
        return
    of_type = [(number, tags) for number, tags in enumerate(readers)
               if sensor.get('type') in tags.sensors]
    number, ours = next(((number, plugin) for number, tags in of_type for plugin in plugins
                         if is_of(plugin, tags)), (None, None))
    # an imu sensor without a plugin publishes nothing: the official burger has one in addition to
    # the plugin that publishes; a ray sensor with a plugin of another kind is a sonar or similar
    if number is None and not plugins:
        number = next((number for number, tags in of_type if tags.needs_sensor), None)
    if number is not None:
        yield _Part((number,), _label(sensor, 'type'), link, sensor, ours)
    elif not of_type or any(tags.needs_sensor for _, tags in of_type):
        yield _Part((), _label(sensor, 'type'), link, sensor, None)
    for plugin in plugins:
        if plugin is not ours:
            yield _Part((), _label(plugin, 'filename'), link, sensor, plugin)


def is_of(plugin: ElementTree.Element, tags: Tags) -> bool:
    """Return whether a plugin is one of those that have the settings."""
    return any(word in plugin.get('filename', '') for word in tags.plugins)


def _label(element: ElementTree.Element, attribute: str) -> str:
    return '{} {}'.format(element.tag, element.get(attribute) or 'without ' + attribute)


def _values_in(part: _Part, tags: Tags, step_s: float) -> Values:
    values: Values = {}
    if tags.frame and part.link:
        values[tags.frame] = part.link
    for row in tags.rows:
        owner = part.plugin if row.owner == 'plugin' else part.sensor
        path = next((path for path in (row.path, row.other_path)
                     if owner is not None and path and owner.find(path) is not None), None)
        if owner is not None and path is not None:
            value = _value(owner, path, row.reader)
            if value is not None:
                values[row.setting] = (
                    nearest_period(value, step_s) if row.reader is RATE else value)
    return values


def _value(owner: ElementTree.Element, path: str, reader: Reader) -> Any:
    text = owner.findtext(path, '').strip()
    try:
        return reader.read(text)
    except (ValueError, KeyError):
        raise SimulationError('<{}> of {}: got {!r}, expected {}'.format(
            path, _label(owner, 'name'), text, reader.expected))


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _name(text: str) -> str:
    if not text.strip('/'):
        raise ValueError(text)
    return text.lstrip('/')


def choice(expected: str, values: Dict[str, Any]) -> Reader:
    """Return a reader of a word, in any case."""
    return Reader(expected, lambda text: values[text.lower()])


NAME, NUMBER = Reader('a name', _name), Reader('a finite number', _number)
INTEGER = Reader('a whole number', int)
FLAG = choice('true, false, 1 or 0', {'true': True, '1': True, 'false': False, '0': False})
POSITIVE = Reader('a finite number', lambda text: max(_number(text), 0.0) or None)
# in Hz, for the setting of a period; 0 means "each physics step" in Gazebo; here it leaves the
# default
RATE = Reader(*POSITIVE)
