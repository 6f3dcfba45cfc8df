"""The cameras in the <gazebo> tags of a URDF.

They are the sensors with a camera plugin of gazebo_plugins; camera_values.py reads their values.
"""
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

from img_recog.settings import SettingError, from_mapping
from img_recog.simulation.descriptions import camera_values
from img_recog.simulation.descriptions.description import root_of
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.settings import CameraSettings, SimulationError

_PLUGINS = {'camera': ('gazebo_ros_camera',), 'wideanglecamera': ('gazebo_ros_camera',),
            'multicamera': ('gazebo_ros_multicamera',),
            'depth': ('gazebo_ros_openni_kinect', 'gazebo_ros_depth_camera')}
_TOPICS = ('camera_image_topic', 'camera_info_topic', 'camera_depth_topic',
           'camera_depth_info_topic', 'camera_points_topic')


class Cameras(NamedTuple):
    """The cameras of a robot, and what of them is not simulated, in words."""

    cameras: Tuple[CameraSettings, ...]
    not_simulated: Tuple[str, ...]


def plugin_of(sensor: ElementTree.Element) -> Optional[ElementTree.Element]:
    """Return the plugin of a <sensor> that publishes the images of a camera, None for none."""
    words = _PLUGINS.get(sensor.get('type', ''), ())
    return next((plugin for plugin in sensor.findall('plugin')
                 if any(word in plugin.get('filename', '') for word in words)), None)


def read(urdf: str) -> Cameras:
    """Return the cameras of a URDF's text, in its order.

    Of two cameras with a topic of the same name, the first one counts.
    Raises SimulationError when `urdf` is not a URDF, or a value cannot be read or used.
    """
    found: List[CameraSettings] = []
    problems: List[str] = []
    owners: Dict[str, str] = {}         # of topics
    robot = root_of(urdf)
    links = [name_of(link) for link in robot.findall('link')]
    for tag in robot.findall('gazebo'):
        for sensor in tag.findall('sensor'):
            plugin = plugin_of(sensor)
            if plugin is None:
                continue
            name, link = name_of(sensor), tag.get('reference', '')
            if link not in links:
                problems.append('sensor {}, because the reference of its <gazebo> tag is no link'
                                .format(name))
                continue
            problems += ['{} of sensor {}'.format(each, name)
                         for each in camera_values.not_simulated(sensor, plugin)]
            for settings in _settings_of(sensor, plugin, link):
                topics: List[str] = [getattr(settings, each) for each in _TOPICS
                                     if getattr(settings, each)]
                taken = next((topic for topic in topics if topic in owners), None)
                if taken is None:
                    owners.update(dict.fromkeys(topics, name))
                    found.append(settings)
                else:
                    problems.append('sensor {}, because its topic {} is one of sensor {}'.format(
                        name, taken, owners[taken]))
    return Cameras(tuple(found), tuple(problems))


def _settings_of(sensor: ElementTree.Element, plugin: ElementTree.Element,
                 link: str) -> Iterator[CameraSettings]:
    for camera, side in _cameras(sensor):
        values: Dict[str, Any] = {'camera_frame': link}
        values.update(camera_values.of_camera(sensor, camera))
        values.update(camera_values.of_plugin(sensor, plugin, side))
        try:
            yield from_mapping(CameraSettings, values)
        except SettingError as error:
            raise SimulationError('sensor {}: {}'.format(
                name_of(sensor), error.problem), error.advice)


def _cameras(sensor: ElementTree.Element) -> List[Tuple[ElementTree.Element, str]]:
    """Return the cameras of a sensor, and which of a stereo pair each is, '' for none."""
    cameras = sensor.findall('camera')
    if sensor.get('type') != 'multicamera':
        return [(cameras[0] if cameras else ElementTree.Element('camera'), '')]
    return [(camera, side) for camera in cameras for side in [camera_values.side_of(camera)]
            if side]
