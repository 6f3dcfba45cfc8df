"""What the <gazebo> elements of a URDF say about the drive, the laser scanner and the IMU.

The tags are those that gazebo_plugins' libgazebo_ros_diff_drive, _laser, _gpu_laser, _imu and
_imu_sensor and Gazebo's own ray and imu sensors read. Friction is read in description.py.
"""
import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple, Union

from img_recog.simulation.description import root_of
from img_recog.simulation.settings import SimulationError, nearest_period

_Values = Dict[str, Union[str, float, int, bool]]


def overrides(urdf: str) -> _Values:
    """Return the settings of the simulator that the <gazebo> tags state, by the setting's name.

    Units are SI, rates in Hz. What no tag states is absent. Names lose their leading slashes.
    Where a drive or sensor comes twice, the first counts.
    Raises SimulationError in one line when `urdf` is no URDF or a value cannot be read.
    """
    values = {}
    for part in _sorted(urdf)[0].values():
        values.update(_stated(part))
    return values


def settings(urdf: str, step_s: float) -> _Values:
    """Return the same with the period of each sensor, the nearest in whole steps, for its rate."""
    values = overrides(urdf)
    for sensor in ('odometry', 'scan', 'imu'):
        rate_hz = values.pop(sensor + '_rate', None)
        if rate_hz is not None:
            values[sensor + '_period_s'] = nearest_period(rate_hz, step_s)
    if 'odometry_period_s' in values:       # of one plugin in Gazebo
        values['joint_states_period_s'] = values['odometry_period_s']
    return values


def not_simulated(urdf: str) -> List[str]:
    """Return what the <gazebo> tags ask for and the simulator has not, in the file's order.

    That is 'plugin FILENAME', 'sensor TYPE', or one of these after the word 'second'.
    Raises SimulationError in one line when `urdf` is no URDF.
    """
    return _sorted(urdf)[1]


class _Part(NamedTuple):
    """A plugin or a sensor with its plugin; role is '' where the simulator has no such thing."""

    role: str
    label: str
    link: Optional[str]
    sensor: Optional[ElementTree.Element]
    plugin: Optional[ElementTree.Element]


def _sorted(urdf: str) -> Tuple[Dict[str, _Part], List[str]]:
    """Return the first part of each role, and the labels of all other parts."""
    first, others = {}, []
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
            # a laser plugin wants a sensor around it
            role = _plugin_role(plugin).replace('scan', '')
            yield _Part(role, _label(plugin, 'filename'), link, None, plugin)
        for sensor in tag.findall('sensor'):
            yield from _sensor_parts(sensor, link)


def _sensor_parts(sensor: ElementTree.Element, link: Optional[str]) -> Iterator[_Part]:
    role = {'ray': 'scan', 'gpu_ray': 'scan', 'imu': 'imu'}.get(sensor.get('type'), '')
    plugins = sensor.findall('plugin')
    ours = next((plugin for plugin in plugins if role and _plugin_role(plugin) == role), None)
    # an imu sensor without a plugin says nothing to ROS: the official burger has one beside the
    # plugin that does; a ray sensor with a plugin of another kind is a sonar or the like
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


def _stated(part: _Part) -> _Values:
    frame = {'scan': 'scan_frame', 'imu': 'imu_frame'}.get(part.role)
    values = {frame: part.link} if frame and part.link else {}
    for setting, kind, where, *paths in _ROWS[part.role]:
        owner = part.plugin if where == 'plugin' else part.sensor
        stated = [path for path in paths if owner is not None and owner.find(path) is not None]
        value = _value(owner, stated[0], kind) if stated else None
        if value is not None:
            values[setting] = value
    return values


class _Kind(NamedTuple):
    """How text is read: `read` raises ValueError or KeyError; None is for what says nothing."""

    wants: str
    read: Callable[[str], Any]


def _value(owner: ElementTree.Element, path: str, kind: _Kind) -> Any:
    text = owner.findtext(path).strip()
    try:
        return kind.read(text)
    except (ValueError, KeyError):
        raise SimulationError('robot_description: <{}> of {}: got {!r}, wants {}'.format(
            path, _label(owner, 'name'), text, kind.wants))


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
_WHOLE = _Kind('a whole number', int)
# a rate of 0 is Gazebo's for "each physics step" and leaves the simulator its own
_POSITIVE = _Kind('a finite number', lambda text: max(_number(text), 0.0) or None)
_FLAG = _Kind('true, false, 1 or 0', lambda text: {
    'true': True, '1': True, 'false': False, '0': False}[text.lower()])
# the numbers are those of the plugin's OdomSource
_SOURCE = _Kind('world or encoder', lambda text: {
    'world': 'world', '1': 'world', 'encoder': 'encoder', '0': 'encoder'}[text.lower()])

# A row: the setting, how it is read, in what, and the paths there, of which the first that
# exists counts. Later rows overrule earlier ones.
_ROWS = {
    'drive': (
        ('left_joint', _NAME, 'plugin', 'leftJoint'),
        ('right_joint', _NAME, 'plugin', 'rightJoint'),
        ('wheel_separation', _NUMBER, 'plugin', 'wheelSeparation'),
        ('wheel_diameter', _NUMBER, 'plugin', 'wheelDiameter'),
        # <torque> is what the plugin's first versions read
        ('wheel_torque', _NUMBER, 'plugin', 'wheelTorque', 'torque'),
        ('wheel_acceleration', _NUMBER, 'plugin', 'wheelAcceleration'),
        ('odometry_source', _SOURCE, 'plugin', 'odometrySource'),
        ('publish_odom_tf', _FLAG, 'plugin', 'publishOdomTF'),
        ('odom_frame', _NAME, 'plugin', 'odometryFrame'),
        ('base_frame', _NAME, 'plugin', 'robotBaseFrame'),
        ('command_topic', _NAME, 'plugin', 'commandTopic'),
        ('odometry_topic', _NAME, 'plugin', 'odometryTopic'),
        ('odometry_rate', _POSITIVE, 'plugin', 'updateRate')),
    'scan': (
        ('scan_rate', _POSITIVE, 'sensor', 'update_rate'),
        ('scan_samples', _WHOLE, 'sensor', 'ray/scan/horizontal/samples'),
        ('scan_angle_min', _NUMBER, 'sensor', 'ray/scan/horizontal/min_angle'),
        ('scan_angle_max', _NUMBER, 'sensor', 'ray/scan/horizontal/max_angle'),
        ('scan_range_min', _NUMBER, 'sensor', 'ray/range/min'),
        ('scan_range_max', _NUMBER, 'sensor', 'ray/range/max'),
        ('scan_noise', _NUMBER, 'sensor', 'ray/noise/stddev'),
        ('scan_frame', _NAME, 'plugin', 'frameName'),
        ('scan_topic', _NAME, 'plugin', 'topicName')),
    'imu': (
        # the IMU plugins add gaussianNoise to rates and accelerations alike; its default, 0,
        # stands in most files, in the official ones beside <imu><noise>: it says nothing
        ('gyro_noise', _POSITIVE, 'plugin', 'gaussianNoise'),
        ('accel_noise', _POSITIVE, 'plugin', 'gaussianNoise'),
        ('imu_rate', _POSITIVE, 'sensor', 'update_rate'),
        ('gyro_noise', _NUMBER, 'sensor', 'imu/noise/rate/stddev'),
        ('accel_noise', _NUMBER, 'sensor', 'imu/noise/accel/stddev'),
        ('imu_frame', _NAME, 'plugin', 'frameName', 'bodyName'),
        ('imu_topic', _NAME, 'plugin', 'topicName'),
        ('imu_rate', _POSITIVE, 'plugin', 'updateRate', 'updateRateHZ'),
        ('gyro_noise', _NUMBER, 'plugin', 'imu/noise/rate/stddev'),
        ('accel_noise', _NUMBER, 'plugin', 'imu/noise/accel/stddev'))}
