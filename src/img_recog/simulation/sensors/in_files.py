"""The sensors in the tags of a model, with their settings."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple, cast

from img_recog.formats import camera_values
from img_recog.formats.gazebo_tags import Tags, Values, is_of, label, values_in
from img_recog.formats.reader import name_of, read as read_text, text_of
from img_recog.model import AttachedFrame, Tag
from img_recog.report import NOT_SIMULATED, Report
from img_recog.rotations import IDENTITY, transform
from img_recog.simulation.sensors.sensor import ConfiguredSensor, SensorKind


class _Part(NamedTuple):
    """A plugin or a sensor with its plugin.

    readers: the numbers of those that read it. is_camera: camera_values.py reads it.
    """

    readers: Sequence[int]
    label: str
    link: str
    sensor: Optional[ElementTree.Element]
    plugin: Optional[ElementTree.Element]
    is_camera: bool = False


def read(tags: Sequence[Tag], step_s: float, kinds: Sequence[SensorKind],
         report: Report, drive: Optional[Tags] = None, with_bare: bool = False
         ) -> Tuple[Values, List[ConfiguredSensor]]:
    """Return what the tags of a model give.

    That is the settings of the first sensor of each kind, by name, and the sensors in the order of
    their kinds. A kind that is not there has one for which settings are looked for elsewhere.

    step_s: of the physics. kinds: of the sensors that count. report: gets what is not simulated:
    'plugin FILENAME' or 'sensor TYPE', after the word 'second' where it is a duplicate. drive: the
    tags that are not those of a sensor. with_bare: whether sensors without a plugin count too.
    Raises SimulationError when a value cannot be read.
    """
    readers: List[Tuple[Tags, Optional[SensorKind]]] = [(drive, None)] if drive else []
    readers += [(kind.read_tags, kind) for kind in kinds]
    sensors: List[ConfiguredSensor] = []
    of_readers: Dict[int, Values] = {}          # of those that have read a part
    parts = list(_parts(tags, [reader for reader, _ in readers], with_bare))
    for part in parts:
        for number in part.readers:
            reader, kind = readers[number]
            if number in of_readers and not reader.frame:
                report.add(NOT_SIMULATED, 'second ' + part.label)
                continue
            values = {} if kind is None else values_in(reader, part.link, part.sensor, part.plugin,
                                                       step_s)
            of_readers.setdefault(number, values)
            if kind is not None and reader.frame and not kind.missing:
                sensors.append(_sensor(kind, values, part, _place_of(part)))
            if part.plugin is not None:
                for what in reader.not_simulated(
                        part.plugin if part.sensor is None else part.sensor):
                    report.add(NOT_SIMULATED, what)
        if not part.readers and not part.is_camera:
            report.add(NOT_SIMULATED, part.label)
    for kind in kinds:
        if kind.is_drawn:
            sensors += _cameras(kind, [part for part in parts if part.is_camera], report)
    values = {name: value for number in sorted(of_readers)
              for name, value in of_readers[number].items()}
    return values, list(_numbered(kinds, sensors))


def _sensor(kind: SensorKind, values: Values, part: _Part,
            place: Optional[AttachedFrame]) -> ConfiguredSensor:
    found = ConfiguredSensor(kind, 0, values, place)
    return found if part.sensor is None else found._replace(
        label=name_of(part.sensor), type=part.sensor.get('type', ''), is_bare=part.plugin is None)


def _numbered(kinds: Sequence[SensorKind],
              sensors: Sequence[ConfiguredSensor]) -> Iterator[ConfiguredSensor]:
    for kind in kinds:
        own = [each for each in sensors if each.kind is kind]
        if not own and not kind.only_in_tags:
            yield ConfiguredSensor(kind)
        for number, each in enumerate(own):
            yield each._replace(number=number)


def _parts(tags: Sequence[Tag], readers: Sequence[Tags], with_bare: bool) -> Iterator[_Part]:
    for link, element in tags:
        for plugin in element.findall('plugin'):
            of_plugin = [number for number, reader in enumerate(readers)
                         if not reader.needs_sensor and is_of(plugin, reader)]
            yield _Part(of_plugin, label(plugin, 'filename'), link, None, plugin)
        for sensor in element.findall('sensor'):
            yield from _sensor_parts(sensor, link, readers, with_bare)


def _sensor_parts(sensor: ElementTree.Element, link: str, readers: Sequence[Tags],
                  with_bare: bool) -> Iterator[_Part]:
    plugins = sensor.findall('plugin')
    camera = camera_values.plugin_of(sensor)
    if camera is not None or with_bare and sensor.get('type') in camera_values.TYPES:
        yield _Part((), name_of(sensor), link, sensor, camera, is_camera=True)
        for plugin in plugins:
            if plugin is not camera:
                yield _Part((), label(plugin, 'filename'), link, sensor, plugin)
        return
    of_type = [number for number, reader in enumerate(readers)
               if sensor.get('type') in reader.sensors]
    parts = [_Part([number for number in of_type if is_of(plugin, readers[number])],
                   label(plugin, 'filename'), link, sensor, plugin) for plugin in plugins]
    # one without a plugin publishes nothing: the official burger has such an imu sensor in
    # addition to the plugin that publishes
    is_bare = not any(part.readers for part in parts)
    if is_bare and with_bare and of_type:
        yield _Part(of_type[:1], label(sensor, 'type'), link, sensor, None)
    elif is_bare and (plugins or not of_type):
        yield _Part((), label(sensor, 'type'), link, sensor, None)
    yield from parts


def _place_of(part: _Part) -> Optional[AttachedFrame]:
    """Return where a sensor is; the plugins outside of sensors name the link."""
    if part.sensor is None:
        link = part.plugin is not None and text_of(part.plugin, 'bodyName')
        return AttachedFrame(link, IDENTITY) if link else None
    text, numbers = text_of(part.sensor, 'pose'), [0.0] * 6
    if text:
        numbers = read_text('6numbers', text, '<pose> of ' + label(part.sensor, 'name')).tolist()
    return AttachedFrame(part.link, transform(numbers[:3], numbers[3:])) if part.link else None


def _cameras(kind: SensorKind, parts: Sequence[_Part],
             report: Report) -> Iterator[ConfiguredSensor]:
    """Yield the cameras; of two with a topic of the same name, the first one counts."""
    owners: Dict[str, str] = {}         # of topics
    for part in parts:
        sensor, name = cast(ElementTree.Element, part.sensor), part.label
        if not part.link:
            report.add(NOT_SIMULATED, 'sensor {}, because its <gazebo> tag has no reference'
                       .format(name))
            continue
        plugin = ElementTree.Element('plugin') if part.plugin is None else part.plugin
        for each in camera_values.not_simulated(sensor, plugin):
            report.add(NOT_SIMULATED, each, 'sensor ' + name)
        for values in camera_values.of_sensor(sensor, plugin):
            topics = [] if part.plugin is None else [
                value for setting, value in values.items() if setting.endswith('_topic')]
            taken = next((topic for topic in topics if topic in owners), None)
            if taken is not None:
                report.add(NOT_SIMULATED, 'sensor {}, because its topic {} is one of sensor {}'
                           .format(name, taken, owners[taken]))
                continue
            owners.update(dict.fromkeys(topics, name))
            yield _sensor(kind, {'camera_frame': part.link, **values}, part,
                          AttachedFrame(part.link, IDENTITY))
