"""The settings that the <gazebo> tags of a URDF give for drive, laser scanner and IMU.

camera_tags.py reads those of cameras.

The tags are those of libgazebo_ros_diff_drive, _laser, _gpu_laser, _imu and _imu_sensor of
gazebo_plugins, and of Gazebo's own ray and imu sensors. description.py reads friction.
"""
import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple, Union

from img_recog.simulation.descriptions import camera_tags
from img_recog.simulation.descriptions.description import root_of
from img_recog.simulation.settings import SimulationError, nearest_period

Values = Dict[str, Union[str, float, int, bool]]


def overrides(urdf: str) -> Values:
    """Return the settings of the simulator that <gazebo> tags give, by the setting's name.

    Units are SI, rates in Hz. Settings without a tag are absent. Leading slashes of names are
    removed. Of two drives or two sensors of a kind, the first counts.
    Raises SimulationError when `urdf` is not a URDF or a value cannot be read.
    """
    values: Values = {}
    for part in _sorted(urdf)[0].values():
        values.update(_values_in(part))
    return values


def settings(urdf: str, step_s: float) -> Values:
    """Return the same, but a period in place of each rate: the nearest one in whole steps.

    step_s: of the physics.
    """
    values = overrides(urdf)
    for sensor in ('odometry', 'scan', 'imu'):
        rate_hz = values.pop(sensor + '_rate', None)
        if rate_hz is not None:
            values[sensor + '_period_s'] = nearest_period(float(rate_hz), step_s)
    if 'odometry_period_s' in values:       # in Gazebo one plugin publishes both
        values['joint_states_period_s'] = values['odometry_period_s']
    return values


def not_simulated(urdf: str) -> List[str]:
    """Return the plugins and sensors in <gazebo> tags that are not simulated, in their order.

    Each is 'plugin FILENAME' or 'sensor TYPE', after the word 'second' where it is a duplicate, or
    a part of a camera.
    Raises SimulationError when `urdf` is not a URDF.
    """
    return _sorted(urdf)[1]


def has_drive(urdf: str) -> bool:
    """Return whether a plugin in the <gazebo> tags drives the robot.

    Raises SimulationError when `urdf` is not a URDF.
    """
    return 'drive' in _sorted(urdf)[0]


class _Part(NamedTuple):
    """A plugin or a sensor with its plugin; role: drive, scan or imu, '' if not simulated."""

    role: str
    label: str
    link: Optional[str]
    sensor: Optional[ElementTree.Element]
    plugin: Optional[ElementTree.Element]


def _sorted(urdf: str) -> Tuple[Dict[str, _Part], List[str]]:
    """Return the first part of each role, and the labels of all other parts."""
    first: Dict[str, _Part] = {}
    others: List[str] = []
    for part in _parts(root_of(urdf)):
        if part.role and part.role not in first:
            first[part.role] = part
        else:
            others.append('second ' + part.label if part.role else part.label)
    return first, others


def _parts(robot: ElementTree.Element) -> Iterator[_Part]:
    for tag in robot.findall('gazebo'):
        link = tag.get('reference')
        for plugin in tag.findall('plugin'):
            # a laser plugin must be in a sensor
            role = _plugin_role(plugin).replace('scan', '')
            yield _Part(role, _label(plugin, 'filename'), link, None, plugin)
        for sensor in tag.findall('sensor'):
            yield from _sensor_parts(sensor, link)


def _sensor_parts(sensor: ElementTree.Element, link: Optional[str]) -> Iterator[_Part]:
    if camera_tags.is_camera(sensor):
        for label in camera_tags.not_simulated(sensor):
            yield _Part('', label, link, sensor, None)
        return
    role = {'ray': 'scan', 'gpu_ray': 'scan', 'imu': 'imu'}.get(sensor.get('type', ''), '')
    plugins = sensor.findall('plugin')
    ours = next((plugin for plugin in plugins if role and _plugin_role(plugin) == role), None)
    # an imu sensor without a plugin publishes nothing: the official burger has one in addition to
    # the plugin that publishes; a ray sensor with a plugin of another kind is a sonar or similar
    if ours is not None or (role == 'scan' and not plugins):
        yield _Part(role, _label(sensor, 'type'), link, sensor, ours)
    elif role != 'imu':
        yield _Part('', _label(sensor, 'type'), link, sensor, None)
    for plugin in plugins:
        if plugin is not ours:
            yield _Part('', _label(plugin, 'filename'), link, sensor, plugin)


def _plugin_role(plugin: ElementTree.Element) -> str:
    words = {'gazebo_ros_diff_drive': 'drive', 'gazebo_ros_imu': 'imu',
             'gazebo_ros_laser': 'scan', 'gazebo_ros_gpu_laser': 'scan'}
    return next((words[word] for word in words if word in plugin.get('filename', '')), '')


def _label(element: ElementTree.Element, attribute: str) -> str:
    return '{} {}'.format(element.tag, element.get(attribute) or 'without ' + attribute)


def _values_in(part: _Part) -> Values:
    values: Values = {}
    frame = {'scan': 'scan_frame', 'imu': 'imu_frame'}.get(part.role)
    if frame and part.link:
        values[frame] = part.link
    for row in _ROWS[part.role]:
        owner = part.plugin if row.owner == 'plugin' else part.sensor
        if owner is None:
            continue
        for path in filter(None, (row.path, row.other_path)):
            if owner.find(path) is not None:
                value = _value(owner, path, row.kind)
                if value is not None:
                    values[row.setting] = value
                break
    return values


class _Kind(NamedTuple):
    """How a text is read.

    read: raises ValueError or KeyError; returns None for a value that leaves the setting alone.
    """

    expected: str
    read: Callable[[str], Any]


class _Row(NamedTuple):
    """Where the value of a setting is found.

    owner: 'plugin' or 'sensor', the element that `path` starts from; other_path: where to look
    when there is nothing at `path`.
    """

    setting: str
    kind: _Kind
    owner: str
    path: str
    other_path: Optional[str] = None


def _value(owner: ElementTree.Element, path: str, kind: _Kind) -> Any:
    text = owner.findtext(path, '').strip()
    try:
        return kind.read(text)
    except (ValueError, KeyError):
        raise SimulationError('<{}> of {}: got {!r}, expected {}'.format(
            path, _label(owner, 'name'), text, kind.expected))


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _name(text: str) -> str:
    if not text.strip('/'):
        raise ValueError(text)
    return text.lstrip('/')


_NAME, _NUMBER = _Kind('a name', _name), _Kind('a finite number', _number)
_INTEGER = _Kind('a whole number', int)
# a rate of 0 means "each physics step" in Gazebo; here it leaves the default
_POSITIVE = _Kind('a finite number', lambda text: max(_number(text), 0.0) or None)
_FLAG = _Kind('true, false, 1 or 0', lambda text: {
    'true': True, '1': True, 'false': False, '0': False}[text.lower()])
# the numbers are those of OdomSource in the plugin
_SOURCE = _Kind('world or encoder', lambda text: {
    'world': 'world', '1': 'world', 'encoder': 'encoder', '0': 'encoder'}[text.lower()])

# Of two rows for a setting, the later one counts.
_ROWS = {
    'drive': (
        _Row('left_joint', _NAME, 'plugin', 'leftJoint'),
        _Row('right_joint', _NAME, 'plugin', 'rightJoint'),
        _Row('wheel_separation', _NUMBER, 'plugin', 'wheelSeparation'),
        _Row('wheel_diameter', _NUMBER, 'plugin', 'wheelDiameter'),
        # <torque> is the name in the plugin's first versions
        _Row('wheel_torque', _NUMBER, 'plugin', 'wheelTorque', 'torque'),
        _Row('wheel_acceleration', _NUMBER, 'plugin', 'wheelAcceleration'),
        _Row('odometry_source', _SOURCE, 'plugin', 'odometrySource'),
        _Row('publish_odom_tf', _FLAG, 'plugin', 'publishOdomTF'),
        _Row('odom_frame', _NAME, 'plugin', 'odometryFrame'),
        _Row('base_frame', _NAME, 'plugin', 'robotBaseFrame'),
        _Row('command_topic', _NAME, 'plugin', 'commandTopic'),
        _Row('odometry_topic', _NAME, 'plugin', 'odometryTopic'),
        _Row('odometry_rate', _POSITIVE, 'plugin', 'updateRate')),
    'scan': (
        _Row('scan_rate', _POSITIVE, 'sensor', 'update_rate'),
        _Row('scan_samples', _INTEGER, 'sensor', 'ray/scan/horizontal/samples'),
        _Row('scan_angle_min', _NUMBER, 'sensor', 'ray/scan/horizontal/min_angle'),
        _Row('scan_angle_max', _NUMBER, 'sensor', 'ray/scan/horizontal/max_angle'),
        _Row('scan_range_min', _NUMBER, 'sensor', 'ray/range/min'),
        _Row('scan_range_max', _NUMBER, 'sensor', 'ray/range/max'),
        _Row('scan_noise', _NUMBER, 'sensor', 'ray/noise/stddev'),
        _Row('scan_frame', _NAME, 'plugin', 'frameName'),
        _Row('scan_topic', _NAME, 'plugin', 'topicName')),
    'imu': (
        # The IMU plugins add gaussianNoise to angular velocities and accelerations alike. Most
        # files have its default, 0 (the official ones together with <imu><noise>): 0 is ignored.
        _Row('gyro_noise', _POSITIVE, 'plugin', 'gaussianNoise'),
        _Row('accel_noise', _POSITIVE, 'plugin', 'gaussianNoise'),
        _Row('imu_rate', _POSITIVE, 'sensor', 'update_rate'),
        _Row('gyro_noise', _NUMBER, 'sensor', 'imu/noise/rate/stddev'),
        _Row('accel_noise', _NUMBER, 'sensor', 'imu/noise/accel/stddev'),
        _Row('imu_frame', _NAME, 'plugin', 'frameName', 'bodyName'),
        _Row('imu_topic', _NAME, 'plugin', 'topicName'),
        _Row('imu_rate', _POSITIVE, 'plugin', 'updateRate', 'updateRateHZ'),
        _Row('gyro_noise', _NUMBER, 'plugin', 'imu/noise/rate/stddev'),
        _Row('accel_noise', _NUMBER, 'plugin', 'imu/noise/accel/stddev'))}
