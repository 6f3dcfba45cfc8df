"""The cameras in the <gazebo> tags of a URDF.

They are the sensors of type camera with the plugin libgazebo_ros_camera, and those of type depth
with libgazebo_ros_openni_kinect, of gazebo_plugins.
"""
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, Optional, Union

from img_recog.settings import SettingError, from_mapping
from img_recog.simulation.descriptions.description import root_of
from img_recog.simulation.descriptions.numbers import read_number, read_numbers
from img_recog.simulation.settings import CameraSettings, SimulationError

Values = Dict[str, Union[str, float, int]]

_PLUGINS = {'camera': 'gazebo_ros_camera', 'depth': 'gazebo_ros_openni_kinect'}
_NUMBERS = (('horizontal_fov', 'camera_horizontal_fov'), ('clip/near', 'camera_near'),
            ('clip/far', 'camera_far'))
_DISTORTION = ('k1', 'k2', 'k3', 'p1', 'p2')
_PLUGIN_DISTORTION = tuple('distortion' + name for name in ('K1', 'K2', 'K3', 'T1', 'T2'))
_MAX_WHOLE = 1e9
_POSE = ('camera_x', 'camera_y', 'camera_z', 'camera_roll', 'camera_pitch', 'camera_yaw')


def is_camera(sensor: ElementTree.Element) -> bool:
    """Return whether a <sensor> is a camera that publishes its images."""
    return _plugin(sensor) is not None


def cameras(urdf: str) -> List[CameraSettings]:
    """Return the cameras of a URDF's text, in its order.

    Raises SimulationError when `urdf` is not a URDF, or a value cannot be read or used.
    """
    found, robot = [], root_of(urdf)
    links = [link.get('name', '') for link in robot.findall('link')]
    for tag in robot.findall('gazebo'):
        for sensor in tag.findall('sensor'):
            plugin = _plugin(sensor)
            if plugin is not None:
                found.append(_settings(sensor, plugin, tag.get('reference', '')))
                if found[-1].camera_frame not in links:
                    raise SimulationError(
                        'sensor {}: its <gazebo> tag has the reference {}, which is not a link'
                        .format(sensor.get('name', ''), found[-1].camera_frame),
                        'the links are ' + ', '.join(links))
    return found


def not_simulated(sensor: ElementTree.Element) -> List[str]:
    """Return what is not simulated of a camera; an empty list for other sensors."""
    plugin, camera, found = _plugin(sensor), sensor.find('camera'), []
    if plugin is None:
        return []
    if plugin.findtext('pointCloudTopicName'):
        found.append('point cloud')
    given = [plugin.findtext(tag) for tag in _PLUGIN_DISTORTION] + [
        camera.findtext('distortion/' + tag) for tag in _DISTORTION if camera is not None]
    if any(text is not None and text.strip().strip('-+0.') for text in given):
        found.append('distortion')
    return ['{} of sensor {}'.format(each, sensor.get('name', '')) for each in found]


def _plugin(sensor: ElementTree.Element) -> Optional[ElementTree.Element]:
    word = _PLUGINS.get(sensor.get('type', ''))
    return None if word is None else next(
        (plugin for plugin in sensor.findall('plugin') if word in plugin.get('filename', '')),
        None)


def _settings(sensor: ElementTree.Element, plugin: ElementTree.Element,
              link: str) -> CameraSettings:
    name = 'sensor {}'.format(sensor.get('name', ''))
    if not link:
        raise SimulationError('{}: its <gazebo> tag has no reference to a link'.format(name),
                              'write <gazebo reference="LINK">')
    values: Values = {'camera_frame': link}
    pose = sensor.find('pose')
    if pose is not None:
        values.update(zip(_POSE, read_numbers('<pose> of ' + name, pose.text, 6).tolist()))
    camera = sensor.find('camera')
    for path, setting in _NUMBERS:
        text = None if camera is None else camera.findtext(path)
        if text is not None:
            values[setting] = read_number('<{}> of {}'.format(path, name), text)
    for path, setting in (('image/width', 'camera_width'), ('image/height', 'camera_height')):
        text = None if camera is None else camera.findtext(path)
        if text is not None:
            values[setting] = _whole('<{}> of {}'.format(path, name), text)
    if camera is not None and camera.findtext('noise/stddev') is not None:
        values['camera_noise'] = read_number('<noise> of ' + name, camera.findtext('noise/stddev'))
    rates = [read_number('<{}> of {}'.format(tag, name), owner.findtext(tag))
             for owner, tag in ((plugin, 'updateRate'), (sensor, 'update_rate'))
             if owner.find(tag) is not None]
    # a rate of 0 means "as fast as possible" in Gazebo; here it leaves the default
    if any(rates):
        values['camera_rate'] = min(filter(None, rates))
    values.update(_names(plugin, sensor.get('type') == 'depth'))
    try:
        return from_mapping(CameraSettings, values)
    except SettingError as error:
        raise SimulationError('{}: {}'.format(name, error.problem), error.advice)


def _names(plugin: ElementTree.Element, has_depth: bool) -> Values:
    """Return the names of topics and of the frame that a plugin gives, and else its defaults."""
    def name(tag: str, default: str) -> str:
        return (plugin.findtext(tag) or '').strip() or default
    camera = name('cameraName', '').strip('/')

    def topic(tag: str, default: str) -> str:
        given = name(tag, default)
        # a name with a leading slash is not below that of the camera
        return '/'.join(filter(None, ('' if given.startswith('/') else camera, given.strip('/'))))
    folder = 'ir/' if has_depth else ''
    values: Values = {
        'camera_image_topic': topic('imageTopicName', folder + 'image_raw'),
        'camera_info_topic': topic('cameraInfoTopicName', folder + 'camera_info')}
    frame = name('frameName', '').strip('/')
    if frame:
        values['camera_optical_frame'] = frame
    if has_depth:
        values['camera_depth_topic'] = topic('depthImageTopicName', 'depth/image_raw')
        values['camera_depth_info_topic'] = topic('depthImageCameraInfoTopicName',
                                                  'depth/camera_info')
    return values


def _whole(name: str, text: str) -> int:
    value = read_number(name, text)
    if not value.is_integer() or abs(value) > _MAX_WHOLE:
        raise SimulationError('{}: got {!r}, expected a whole number'.format(name, text))
    return int(value)
