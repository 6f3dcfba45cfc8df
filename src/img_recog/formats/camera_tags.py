"""The cameras in the <gazebo> tags of a URDF.

They are the sensors with a camera plugin of gazebo_plugins; camera_values.py reads their values.
"""
import xml.etree.ElementTree as ElementTree
from typing import Container, Dict, List, NamedTuple, Optional, Sequence, Tuple

from img_recog.formats import camera_values
from img_recog.formats.camera_values import Values
from img_recog.formats.texts import name_of

_PLUGINS = {'camera': ('gazebo_ros_camera',), 'wideanglecamera': ('gazebo_ros_camera',),
            'multicamera': ('gazebo_ros_multicamera',),
            'depth': ('gazebo_ros_openni_kinect', 'gazebo_ros_depth_camera')}
_TOPICS = ('camera_image_topic', 'camera_info_topic', 'camera_depth_topic',
           'camera_depth_info_topic', 'camera_points_topic')


class Camera(NamedTuple):
    """A camera; sensor: the name of that; values: settings by name."""

    sensor: str
    values: Values


def plugin_of(sensor: ElementTree.Element) -> Optional[ElementTree.Element]:
    """Return the plugin of a <sensor> that publishes the images of a camera, None for none."""
    words = _PLUGINS.get(sensor.get('type', ''), ())
    return next((plugin for plugin in sensor.findall('plugin')
                 if any(word in plugin.get('filename', '') for word in words)), None)


def read(tags: Sequence[ElementTree.Element],
         links: Container[str]) -> Tuple[List[Camera], List[str]]:
    """Return the cameras in <gazebo> tags, in their order, and what of them is not simulated.

    links: the names of those that can carry one. Of two cameras with a topic of the same name, the
    first one counts.
    Raises SimulationError when a value cannot be read.
    """
    found: List[Camera] = []
    problems: List[str] = []
    owners: Dict[str, str] = {}         # of topics
    for tag in tags:
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
            for camera, side in _cameras(sensor):
                values = {'camera_frame': link, **camera_values.of_camera(sensor, camera),
                          **camera_values.of_plugin(sensor, plugin, side)}
                topics = [values[topic] for topic in _TOPICS if values.get(topic)]
                taken = next((topic for topic in topics if topic in owners), None)
                if taken is None:
                    owners.update(dict.fromkeys(topics, name))
                    found.append(Camera(name, values))
                else:
                    problems.append('sensor {}, because its topic {} is one of sensor {}'.format(
                        name, taken, owners[taken]))
    return found, problems


def _cameras(sensor: ElementTree.Element) -> List[Tuple[ElementTree.Element, str]]:
    """Return the cameras of a sensor, and which of a stereo pair each is, '' for none."""
    cameras = sensor.findall('camera')
    if sensor.get('type') != 'multicamera':
        return [(cameras[0] if cameras else ElementTree.Element('camera'), '')]
    return [(camera, side) for camera in cameras for side in [camera_values.side_of(camera)]
            if side]
