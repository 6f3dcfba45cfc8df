"""Reads which robots there are: from a number, or from a YAML file."""
import os
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Collection, Dict, List, Mapping, NamedTuple, Optional

import rosgraph

from img_recog.camera.usb_cam_settings import FOURCC
from img_recog.camera_arguments import PIXELS, RATES, ROBOT, SYNTHETIC, check_drawn
from img_recog.errors import UserError, one_line, shortened
from img_recog.formats.markup import MarkupError
from img_recog.formats.yaml_text import read_yaml
from img_recog.settings import (MAX_INT, SettingError, Settings, any_value, from_mapping,
                                not_empty, one_of, setting, setting_fields, unknown)

MAX_ROBOTS = 100
_NAME = 'tb3_{}'            # of turtlebot3_gazebo's multi_turtlebot3.launch
_POSE = ('x_pos', 'y_pos', 'z_pos', 'yaw')
_PATHS = ('urdf', 'colors')
_FILE = 'file://'
_SIMULATION = 'simulation'
_AUTO = 'auto'
_CAMERAS = (SYNTHETIC, ROBOT, 'none')
# namespaces of nodes, and names of the world in services of gazebo_ros
_RESERVED = ('gazebo', 'map', 'robots', 'world')
_MAX_NAME = 100


class RobotListError(UserError):
    """There is no list of robots."""


@dataclass(frozen=True)
class NodeSettings(Settings):
    """What the nodes of a robot are started with; see the arguments of demo.launch.

    All but the URDF are arguments of robot.launch, too.
    urdf, colors: paths, '' for those of this package. camera_info_url: '' for usb_cam's default.
    """

    urdf: str = setting('', any_value())
    camera: str = setting('auto', not_empty())
    colors: str = setting('', any_value())
    image_width: int = setting(640, PIXELS)
    image_height: int = setting(480, PIXELS)
    framerate: float = setting(30.0, RATES)
    pixel_format: str = setting('mjpeg', one_of(*sorted(FOURCC)))
    camera_info_url: str = setting('', any_value())
    recognition: bool = setting(True)
    teleop: bool = setting(True)
    safe: bool = setting(False)

    def __post_init__(self):
        super().__post_init__()
        if self.camera in (SYNTHETIC, ROBOT):
            check_drawn(self)


class RobotRow(NamedTuple):
    """A robot of the list.

    simulation: its parameters in the simulator; without x_pos and y_pos, it gets a free place.
    description: the URDF, a text, when it was read. colors: What its file of colors holds, then.
    """

    name: str
    nodes: NodeSettings
    simulation: Dict[str, Any]
    description: str = ''
    colors: Optional[Dict[str, Any]] = None


class RobotList(NamedTuple):
    """A list of robots.

    Attributes:
        robots: Robots that can be.
        problems: Why the others cannot be, by name, or by position for a robot without a name.
    """

    robots: List[RobotRow]
    problems: Dict[str, str]


def read_robots(robots: str, defaults: Mapping[str, Any],
                find: Callable[[str], Optional[str]]) -> RobotList:
    """Return the robots that the argument `robots` means.

    robots: a number of robots tb3_0, tb3_1 and so on, or the path of a YAML file: a list of
    mappings with name, and optionally x_pos, y_pos, z_pos, yaw, simulation and the fields of
    NodeSettings. defaults: of these fields. find: returns the path of a package:// URI.
    Raises RobotListError when there is no list.
    """
    text = robots.strip()
    try:
        count = int(text)
    except ValueError:
        return _from_file(text, defaults, find)
    if not 1 <= count <= MAX_ROBOTS:
        raise RobotListError(
            'robots: got {}, allowed is a number from 1 to {}, or the path of a YAML file'.format(
                shortened(text), MAX_ROBOTS))
    nodes = from_mapping(NodeSettings, defaults)
    return RobotList([RobotRow(_NAME.format(number), nodes, {}) for number in range(count)], {})


def _from_file(path: str, defaults: Mapping[str, Any],
               find: Callable[[str], Optional[str]]) -> RobotList:
    try:
        entries = read_yaml(path)
    except (OSError, MarkupError) as error:
        raise RobotListError('robots: cannot read {}: {}'.format(path, one_line(error)),
                             'give a number of robots, or the path of a YAML file')
    if not isinstance(entries, list) or not 1 <= len(entries) <= MAX_ROBOTS:
        raise RobotListError('robots: {}: got {}, expected a list of 1 to {} robots, each like '
                             '- name: tb3_0'.format(path, _described(entries), MAX_ROBOTS))
    robots: List[RobotRow] = []
    problems: Dict[str, str] = {}
    for number, entry in enumerate(entries, 1):
        label = 'robot {} of the list'.format(number)
        try:
            # also different from those that cannot be
            label = _name_of(entry, [*problems, *(robot.name for robot in robots)])
            robots.append(_robot(label, entry, defaults, os.path.dirname(path), find))
        except UserError as error:
            problems[label] = one_line(error)
    return RobotList(robots, problems)


def _described(entries: Any) -> str:
    return '{} robots'.format(len(entries)) if isinstance(entries, list) else (
        'nothing' if entries is None else type(entries).__name__)


def _name_of(entry: Any, used: Collection[str]) -> str:
    if not isinstance(entry, dict) or 'name' not in entry:
        raise RobotListError('got {}, expected a mapping with a name, like - name: tb3_0'.format(
            shortened(repr(entry)) if not isinstance(entry, dict) else 'no name'))
    name = entry['name']
    if not isinstance(name, str):
        raise RobotListError('name: got {}, expected a text; put it in quotes'.format(
            shortened(repr(name))))
    if not rosgraph.names.is_legal_base_name(name):
        raise RobotListError('name: got {}, allowed are letters, digits and _, the first a letter'
                             .format(shortened(repr(name))))
    if len(name) > _MAX_NAME:
        raise RobotListError('name: got {}, allowed are {} characters'.format(
            shortened(name), _MAX_NAME))
    if name in _RESERVED:
        raise RobotListError('the name {} is that of a part of the system'.format(name),
                             'give the robot another name')
    if name in used:
        raise RobotListError('the name {} is used by a robot before it'.format(name),
                             'give each robot another name')
    return name


def _robot(name: str, entry: Dict[Any, Any], defaults: Mapping[str, Any], folder: str,
           find: Callable[[str], Optional[str]]) -> RobotRow:
    fields = [field.name for field in setting_fields(NodeSettings)]
    known = ['name', _SIMULATION, *_POSE, *fields]
    for key in entry:
        if key not in known:
            raise RobotListError(unknown(str(key), known))
    simulation = entry.get(_SIMULATION) or {}
    if not isinstance(simulation, dict):
        raise RobotListError('simulation: got {}, expected parameters of the simulator, like '
                             '{{scan_noise: 0.0}}'.format(shortened(repr(simulation))))
    poses = {key: entry[key] for key in _POSE if key in entry}
    for key, value in {**simulation, **poses}.items():
        if not _is_parameter(key, value):
            raise RobotListError('parameter {}: got {}, allowed is a number, a text, true or false'
                                 .format(shortened(key), shortened(repr(value))))
    values = {**defaults, **{key: value for key, value in entry.items() if key in fields}}
    readers: Dict[str, Callable[[Any, str], Any]] = {
        **{key: partial(_path, key, find) for key in _PATHS},
        'camera': camera, 'camera_info_url': _beside}
    values.update((key, read(entry[key], folder)) for key, read in readers.items() if key in entry)
    return RobotRow(name, from_mapping(NodeSettings, values), {**simulation, **poses})


def _is_parameter(key: Any, value: Any) -> bool:
    """Return whether the parameter server takes a parameter, and the simulator may know it."""
    if not isinstance(key, str) or not rosgraph.names.is_legal_base_name(key):
        return False
    # XML-RPC has no control characters
    return isinstance(value, (bool, float)) or (
        isinstance(value, str) and value.isprintable()) or (
        isinstance(value, int) and abs(value) <= MAX_INT)


def camera(value: Any, folder: str) -> str:
    """Return the camera: a file in the folder by its path, everything else as it is.

    Raises SettingError.
    """
    if not isinstance(value, str) or not value.isprintable() or not value:
        raise SettingError('camera', value, 'auto, synthetic, robot, none, the path of a device, '
                           'video, image or folder of images, or a URL')
    beside = os.path.join(folder, value)
    if value == _AUTO:
        return SYNTHETIC       # robots cannot share a device
    if value in _CAMERAS or '://' in value:
        return value
    if not os.path.exists(beside):
        raise SettingError('camera', value, 'a path that exists, or one of {}'.format(
            ', '.join(_CAMERAS)))
    return beside


def _beside(url: Any, folder: str) -> Any:
    """Return a URL; the path of file://PATH may be relative to the folder of the list."""
    if isinstance(url, str) and url.startswith(_FILE) and url[len(_FILE):][:1] not in '/$':
        return _FILE + os.path.join(folder, url[len(_FILE):])
    return url


def _path(key: str, find: Callable[[str], Optional[str]], value: Any, folder: str) -> str:
    """Return a path that is given relative to the folder of the list, or as a package:// URI."""
    if not isinstance(value, str) or not value.isprintable():
        raise SettingError(key, value, 'the path of a file')
    path = find(value) if '://' in value else os.path.join(folder, value)
    if path is None or os.path.exists(path) and not os.path.isfile(path):
        raise SettingError(key, value, 'the path or package:// URI of a file that exists')
    return path
