"""The cameras of a model: in the <gazebo> tags of a URDF, or the links of an SDF.

They are the sensors with a camera plugin of gazebo_plugins; camera_values.py reads their values.
"""
import xml.etree.ElementTree as ElementTree
from typing import Container, Dict, List, Sequence, Tuple

from img_recog.formats import camera_values
from img_recog.formats.gazebo_tags import SensorTag, Tags
from img_recog.formats.texts import name_of
from img_recog.model import Frame, Tag
from img_recog.rotations import IDENTITY

TAGS = Tags((), ())         # they are read here
_TOPICS = ('camera_image_topic', 'camera_info_topic', 'camera_depth_topic',
           'camera_depth_info_topic', 'camera_points_topic')


def read(tags: Sequence[Tag], links: Container[str],
         with_bare: bool = False) -> Tuple[List[SensorTag], List[str]]:
    """Return the cameras of a model, in their order, and what of them is not simulated.

    links: the names of those that can carry one; with_bare: whether those without a plugin count
    too. Of two cameras with a topic of the same name, the first one counts.
    Raises SimulationError when a value cannot be read.
    """
    found: List[SensorTag] = []
    problems: List[str] = []
    owners: Dict[str, str] = {}         # of topics
    for link, element in tags:
        for sensor in element.findall('sensor'):
            plugin, is_bare = camera_values.plugin_of(sensor), False
            if plugin is None:
                is_bare = with_bare and sensor.get('type') in camera_values.TYPES
                if not is_bare:
                    continue
                plugin = ElementTree.Element('plugin')
            name = name_of(sensor)
            if link not in links:
                problems.append('sensor {}, because the reference of its <gazebo> tag is no link'
                                .format(name))
                continue
            problems += ['{} of sensor {}'.format(each, name)
                         for each in camera_values.not_simulated(sensor, plugin)]
            for camera, side in _cameras(sensor):
                values = {'camera_frame': link, **camera_values.of_camera(sensor, camera),
                          **camera_values.of_plugin(sensor, plugin, side)}
                topics = [values[topic] for topic in _TOPICS
                          if values.get(topic) and not is_bare]
                taken = next((topic for topic in topics if topic in owners), None)
                if taken is None:
                    owners.update(dict.fromkeys(topics, name))
                    found.append(SensorTag(TAGS, values, Frame(link, IDENTITY), name,
                                           sensor.get('type', ''), is_bare))
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
