"""The settings that the <sensor>s and <plugin>s of a model give for the drive and the sensors.

They are in the <gazebo> tags of a URDF, and in the links and the models of an SDF.

drive_tags.py has the rows of drives, camera_values.py reads those of cameras, urdf.py
friction. The rows of each kind of sensors are beside its class, as `Tags`;
simulation/sensors/in_files.py looks for them.
"""
import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, Iterable, Mapping, NamedTuple, Optional, Sequence

from img_recog.errors import SimulationError
from img_recog.formats import reader
from img_recog.formats.reader import Type, text_of
from img_recog.settings import computable, nearest_period

Values = Dict[str, Any]
# of a skid-steered robot, the joints of its two sides
CORNERS = {'left_joint': ('leftFrontJoint', 'leftRearJoint'),
           'right_joint': ('rightFrontJoint', 'rightRearJoint')}


class Row(NamedTuple):
    """Where the value of a setting is found.

    owner: 'plugin' or 'sensor', the element that `path` starts from; other_path: where to look
    when there is nothing at `path`.
    """

    setting: str
    reader: Type
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


class DriveDescription(NamedTuple):
    """What a file says of how a robot is driven.

    tags: of the plugin; values: settings by name.
    """

    tags: Tags
    values: Values = {}

    def with_settings(self, given: Values) -> 'DriveDescription':
        """Return the drive with settings by name; its own hold where those have none."""
        values = {**self.values, **given}
        for side, pair in CORNERS.items():     # the front and the rear wheels together
            names = [str(values.pop(corner)) for corner in pair if corner in values]
            if names:
                values[side] = ', '.join(dict.fromkeys(names))
        return self._replace(values=values)


def is_of(plugin: ElementTree.Element, tags: Tags) -> bool:
    """Return whether a plugin is one of those that have the settings."""
    return any(word in plugin.get('filename', '') for word in tags.plugins)


def label(element: ElementTree.Element, attribute: str) -> str:
    """Return what messages call a sensor or a plugin."""
    return '{} {}'.format(element.tag, element.get(attribute) or 'without ' + attribute)


def values_in(tags: Tags, link: str, sensor: Optional[ElementTree.Element],
              plugin: Optional[ElementTree.Element], step_s: float) -> Values:
    """Return the settings that a sensor and its plugin give, or one alone, by name: SI units, and
    periods that are whole steps.

    link: of the tag. step_s: of the physics. Settings without a tag are absent. Leading slashes of
    names are removed. Raises SimulationError when a value cannot be read.
    """
    values: Values = {}
    if tags.frame and link:
        values[tags.frame] = link
    for row in tags.rows:
        owner = plugin if row.owner == 'plugin' else sensor
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
    return {**_defaults_in(tags, plugin, step_s), **values}


def _defaults_in(tags: Tags, plugin: Optional[ElementTree.Element], step_s: float) -> Values:
    found: Values = dict(tags.bare) if plugin is None else {}
    for word, defaults in tags.defaults.items():
        if plugin is not None and word in plugin.get('filename', ''):
            found.update(defaults)
    return {name: max(1, round(value / step_s)) * step_s if name.endswith('_period_s') else value
            for name, value in found.items()}


def _in_namespace(topic: str, plugin: ElementTree.Element) -> str:
    """Return a topic, without a leading slash, as the plugin makes it."""
    namespace = text_of(plugin, 'robotNamespace').strip('/')
    return topic.lstrip('/') if topic.startswith('/') or not namespace else '/'.join(
        (namespace, topic))


def _value(owner: ElementTree.Element, path: str, kind: Type) -> Any:
    if kind.of_element:
        return kind.read(owner.find(path), '{} of {}'.format(path, label(owner, 'name')))
    text = text_of(owner, path)
    if kind is NAMES:
        text = ', '.join(filter(None, ((each.text or '').strip() for each in owner.findall(path))))
    try:
        return kind.read(text)
    except (ValueError, KeyError):
        raise SimulationError('<{}> of {}: got {!r}, expected {}'.format(
            path, label(owner, 'name'), text, kind.allowed))


def _topic(text: str) -> str:
    if not text.strip('/'):
        raise ValueError(text)
    return text


def _deviation(text: str) -> Optional[float]:
    """Return a standard deviation, of several their root mean square, None for 0."""
    values = [computable(reader.number(each)) for each in text.split()]
    if not values:
        raise ValueError(text)
    return math.sqrt(sum(value ** 2 for value in values) / len(values)) or None


def choice(expected: str, values: Dict[str, Any]) -> Type:
    """Return the type of a word, in any case."""
    return Type(expected, lambda text: values[text.lower()])


NAME = Type('a name', lambda text: _topic(text).lstrip('/'))
# of all elements at the path
NAMES = Type('names', lambda text: ', '.join(_topic(name).strip('/ ')
                                             for name in text.split(',')))
# in the <robotNamespace> of the plugin, unless it has a leading slash
TOPIC = Type('a name', _topic)
NUMBER, INTEGER, FLAG = reader.NUMBER, reader.WHOLE, reader.FLAG
POSITIVE = Type('a finite number', lambda text: max(reader.number(text), 0.0) or None)
# for one or each axis
DEVIATION = Type('finite numbers', _deviation)
# in Hz, for the setting of a period; 0 means each step of the physics, as in Gazebo
RATE = Type('a finite number',
            lambda text: max(computable(reader.number(text)), 0.0) or math.inf)
EACH_STEP = 0.0             # the default of a period
