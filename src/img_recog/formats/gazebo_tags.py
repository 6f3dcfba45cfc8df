"""The settings that the <sensor>s and <plugin>s of a model give for the drive and the sensors.

They are in the <gazebo> tags of a URDF, and in the links and the models of an SDF.

drive_tags.py has the rows of drives, camera_tags.py reads those of cameras, urdf_links.py
friction. The rows of each kind of sensors are beside its class, as `Tags`.
"""
import math
import xml.etree.ElementTree as ElementTree
from typing import (Any, Callable, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional,
                    Sequence)

from img_recog.errors import SimulationError
from img_recog.formats import camera_values
from img_recog.formats.numbers import read_numbers, whole
from img_recog.formats.texts import name_of, text_of
from img_recog.model import Frame, Tag
from img_recog.rotations import IDENTITY, transform
from img_recog.settings import nearest_period

Values = Dict[str, Any]


class Reader(NamedTuple):
    """How a text is read.

    read: raises ValueError or KeyError; returns None for a value that leaves the setting alone.
    of_element: whether it gets the element and what it is called instead; it raises
    SimulationError then.
    """

    expected: str
    read: Callable[..., Any]
    of_element: bool = False


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
    counts. sensors: the types of <sensor> that such a plugin can be in; needs_sensor: whether it
    must be in one. frame: the setting that is the link of the tag, unless a row has it; a robot
    can have several sensors of a kind that has one. defaults: settings that hold where a plugin
    has none, by a part of its file name; bare: those of a sensor without a plugin; their periods
    become whole steps. not_simulated:
    returns what of a <sensor>, or of a plugin outside of one, is not simulated.
    """

    plugins: Sequence[str]
    rows: Sequence[Row]
    sensors: Sequence[str] = ()
    frame: str = ''
    needs_sensor: bool = False
    defaults: Mapping[str, Values] = {}
    bare: Values = {}
    not_simulated: Callable[[ElementTree.Element], Iterable[str]] = lambda owner: ()


class SensorTag(NamedTuple):
    """A sensor in a file.

    tags: of its kind; values: its settings, by name; place: None if nothing says it; label: its
    own name; type: of its <sensor>, '' if it is a plugin alone; is_bare: whether it has no plugin
    that publishes what it measures.
    """

    tags: Tags
    values: Values
    place: Optional[Frame]
    label: str = ''
    type: str = ''
    is_bare: bool = False


class Found(NamedTuple):
    """What is in <gazebo> tags.

    values: the settings that they give for what is there once, and for the first sensor of each
    kind, by name: SI units, and periods that are whole steps. sensors: all that are simulated.
    not_simulated: the plugins and sensors that are not simulated, in their order. Each is 'plugin
    FILENAME' or 'sensor TYPE', after the word 'second' where it is a duplicate. Those of cameras
    are not among them.
    """

    values: Values
    not_simulated: List[str]
    sensors: List[SensorTag]


def read(tags: Sequence[Tag], step_s: float, readers: Sequence[Tags],
         with_bare: bool = False) -> Found:
    """Return what the tags of a model give.

    step_s: of the physics. with_bare: whether sensors without a plugin count too. Settings without
    a tag are absent. Leading slashes of names are removed. Of two drives, the first counts.
    Raises SimulationError when a value cannot be read.
    """
    found = Found({}, [], [])
    known: List[Tags] = []          # those that have read a part
    of_readers: List[Values] = [{} for _ in readers]
    for part in _parts(tags, readers, with_bare):
        new = [reader for reader in part.readers if reader not in known]
        for reader in part.readers:
            if reader in new or reader.frame:
                values = _values_in(part, reader, step_s)
                if reader in new:
                    of_readers[readers.index(reader)] = values
                if reader.frame:
                    found.sensors.append(_sensor(reader, values, part))
                owner = part.plugin if part.sensor is None else part.sensor
                if owner is not None and part.plugin is not None:
                    found.not_simulated.extend(reader.not_simulated(owner))
            else:
                found.not_simulated.append('second ' + part.label)
        if not part.readers:
            found.not_simulated.append(part.label)
        known += new
    for values in of_readers:       # a drive comes first
        found.values.update(values)
    return found


class _Part(NamedTuple):
    """A plugin or a sensor with its plugin; readers: those that read it."""

    readers: Sequence[Tags]
    label: str
    link: str
    sensor: Optional[ElementTree.Element]
    plugin: Optional[ElementTree.Element]


def _sensor(reader: Tags, values: Values, part: _Part) -> SensorTag:
    if part.sensor is None:
        return SensorTag(reader, values, _place_of(part))
    return SensorTag(reader, values, _place_of(part), name_of(part.sensor),
                     part.sensor.get('type', ''), part.plugin is None)


def _parts(tags: Sequence[Tag], readers: Sequence[Tags], with_bare: bool) -> Iterator[_Part]:
    for link, element in tags:
        for plugin in element.findall('plugin'):
            of_plugin = [reader for reader in readers
                         if not reader.needs_sensor and is_of(plugin, reader)]
            yield _Part(of_plugin, _label(plugin, 'filename'), link, None, plugin)
        for sensor in element.findall('sensor'):
            yield from _sensor_parts(sensor, link, readers, with_bare)


def _sensor_parts(sensor: ElementTree.Element, link: str, readers: Sequence[Tags],
                  with_bare: bool) -> Iterator[_Part]:
    plugins = sensor.findall('plugin')
    camera = camera_values.plugin_of(sensor)
    if camera is not None or with_bare and sensor.get('type') in camera_values.TYPES:
        for plugin in plugins:
            if plugin is not camera:
                yield _Part((), _label(plugin, 'filename'), link, sensor, plugin)
        return
    of_type = [tags for tags in readers if sensor.get('type') in tags.sensors]
    parts = [_Part([tags for tags in of_type if is_of(plugin, tags)],
                   _label(plugin, 'filename'), link, sensor, plugin) for plugin in plugins]
    # one without a plugin publishes nothing: the official burger has such an imu sensor in
    # addition to the plugin that publishes
    is_bare = not any(part.readers for part in parts)
    if is_bare and with_bare and of_type:
        yield _Part(of_type[:1], _label(sensor, 'type'), link, sensor, None)
    elif is_bare and (plugins or not of_type):
        yield _Part((), _label(sensor, 'type'), link, sensor, None)
    yield from parts


def _place_of(part: _Part) -> Optional[Frame]:
    """Return where a sensor is; the plugins outside of sensors name the link."""
    if part.sensor is None:
        link = part.plugin is not None and text_of(part.plugin, 'bodyName')
        return Frame(link, IDENTITY) if link else None
    text, numbers = text_of(part.sensor, 'pose'), [0.0] * 6
    if text:
        numbers = read_numbers('<pose> of ' + _label(part.sensor, 'name'), text, 6).tolist()
    return Frame(part.link, transform(numbers[:3], numbers[3:])) if part.link else None


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
        # one of a sensor without a text has the default, as for sdformat
        path = next((path for path in (row.path, row.other_path)
                     if owner is not None and path and owner.find(path) is not None
                     and (row.owner == 'plugin' or row.reader.of_element
                          or text_of(owner, path))), None)
        if owner is not None and path is not None:
            value = _value(owner, path, row.reader)
            if value is not None:
                # of a sensor's and a plugin's, the lower one counts
                if row.reader is RATE:
                    value = max(nearest_period(value, step_s), values.get(row.setting, 0))
                elif row.reader is TOPIC:
                    value = _in_namespace(value, owner)
                values[row.setting] = value
    return {**_defaults_in(part, tags, step_s), **values}


def _defaults_in(part: _Part, tags: Tags, step_s: float) -> Values:
    found: Values = dict(tags.bare) if part.plugin is None else {}
    for word, defaults in tags.defaults.items():
        if part.plugin is not None and word in part.plugin.get('filename', ''):
            found.update(defaults)
    return {name: max(1, round(value / step_s)) * step_s if name.endswith('_period_s') else value
            for name, value in found.items()}


def _in_namespace(topic: str, plugin: ElementTree.Element) -> str:
    """Return a topic, without a leading slash, as the plugin makes it."""
    namespace = text_of(plugin, 'robotNamespace').strip('/')
    return topic.lstrip('/') if topic.startswith('/') or not namespace else '/'.join(
        (namespace, topic))


def _value(owner: ElementTree.Element, path: str, reader: Reader) -> Any:
    if reader.of_element:
        return reader.read(owner.find(path), '{} of {}'.format(path, _label(owner, 'name')))
    text = text_of(owner, path)
    if reader is NAMES:
        text = ', '.join(filter(None, ((each.text or '').strip() for each in owner.findall(path))))
    try:
        return reader.read(text)
    except (ValueError, KeyError):
        raise SimulationError('<{}> of {}: got {!r}, expected {}'.format(
            path, _label(owner, 'name'), text, reader.expected))


def _number(text: str) -> float:
    """Return the number that a text begins with, as sdformat reads it."""
    value = float(next(iter(text.split()), ''))
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _topic(text: str) -> str:
    if not text.strip('/'):
        raise ValueError(text)
    return text


def _deviation(text: str) -> Optional[float]:
    """Return a standard deviation, of several their root mean square, None for 0."""
    values = [_number(each) for each in text.split()]
    if not values:
        raise ValueError(text)
    return math.sqrt(sum(value ** 2 for value in values) / len(values)) or None


def choice(expected: str, values: Dict[str, Any]) -> Reader:
    """Return a reader of a word, in any case."""
    return Reader(expected, lambda text: values[text.lower()])


NAME = Reader('a name', lambda text: _topic(text).lstrip('/'))
# of all elements at the path
NAMES = Reader('names', lambda text: ', '.join(_topic(name).strip('/ ')
                                               for name in text.split(',')))
# in the <robotNamespace> of the plugin, unless it has a leading slash
TOPIC = Reader('a name', _topic)
NUMBER = Reader('a finite number', _number)
INTEGER = Reader('a whole number', whole)
FLAG = choice('true, false, 1 or 0', {'true': True, '1': True, 'false': False, '0': False})
POSITIVE = Reader('a finite number', lambda text: max(_number(text), 0.0) or None)
# for one or each axis
DEVIATION = Reader('finite numbers', _deviation)
# in Hz, for the setting of a period; 0 means each step of the physics, as in Gazebo
RATE = Reader('a finite number', lambda text: max(_number(text), 0.0) or math.inf)
EACH_STEP = 0.0             # the default of a period
