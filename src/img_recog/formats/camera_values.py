"""The settings of a camera that SDF's <sensor> and the plugins of gazebo_plugins give."""
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterator, List, Optional

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats import lenses, noises
from img_recog.formats.numbers import read_number, read_numbers, read_whole
from img_recog.formats.texts import name_of, text_of
from img_recog.rotations import Transform, transform

Values = Dict[str, Any]

_PLUGINS = {'camera': ('gazebo_ros_camera',), 'wideanglecamera': ('gazebo_ros_camera',),
            'multicamera': ('gazebo_ros_multicamera',),
            'depth': ('gazebo_ros_openni_kinect', 'gazebo_ros_depth_camera')}
TYPES = tuple(_PLUGINS)
_LEFT, _RIGHT = 'left', 'right'
_DEPTH, _WIDE = 'depth', 'wideanglecamera'
_POSE = ('camera_x', 'camera_y', 'camera_z', 'camera_roll', 'camera_pitch', 'camera_yaw')
_MAX_IGNORED = 1e-6         # of a coefficient: examples have 0.00000001
# in <camera>
_NUMBERS = {'horizontal_fov': 'camera_horizontal_fov', 'clip/near': 'camera_near',
            'clip/far': 'camera_far'}
_WHOLE_NUMBERS = {'image/width': 'camera_width', 'image/height': 'camera_height'}
# of SDF
_DEFAULTS = {'camera_width': 320, 'camera_height': 240, 'camera_horizontal_fov': 1.047,
             'camera_near': 0.1, 'camera_far': 100.0}
# of <image><format>, as libgazebo_ros_camera names them
_ENCODINGS = {'R8G8B8': 'rgb8', 'RGB_INT8': 'rgb8', 'B8G8R8': 'bgr8', 'BGR_INT8': 'bgr8',
              'L8': 'mono8', 'L_INT8': 'mono8'}
_DISTORTION = {'distortion/' + name: 'camera_' + name for name in ('k1', 'k2', 'k3', 'p1', 'p2')}
_LENS = {'lens/cutoff_angle': 'camera_cutoff_angle'}
_CUSTOM = {'lens/custom_function/' + name: 'camera_' + name for name in ('c1', 'c2', 'c3', 'f')}
_LENS_SIZE = {'lens/env_texture_size': 'camera_env_texture_size'}
# in the plugin; Gazebo writes them to the camera info, and does not distort the image by them
_CLAIMED_DISTORTION = tuple('distortion' + name for name in ('K1', 'K2', 'K3', 'T1', 'T2'))
_OTHER_TOPICS = {'reflectanceTopicName': 'reflectance', 'normalsTopicName': 'normals'}


def plugin_of(sensor: ElementTree.Element) -> Optional[ElementTree.Element]:
    """Return the plugin of a <sensor> that publishes the images of a camera, None for none."""
    words = _PLUGINS.get(sensor.get('type', ''), ())
    return next((plugin for plugin in sensor.findall('plugin')
                 if any(word in plugin.get('filename', '') for word in words)), None)


def of_sensor(sensor: ElementTree.Element, plugin: ElementTree.Element) -> Iterator[Values]:
    """Yield the settings of each camera of a <sensor> with a plugin.

    Raises SimulationError naming what cannot be read.
    """
    cameras = sensor.findall('camera')
    if sensor.get('type') == 'multicamera':
        pairs = [(camera, _side_of(camera)) for camera in cameras if _side_of(camera)]
    else:
        pairs = [(cameras[0] if cameras else ElementTree.Element('camera'), '')]
    for camera, side in pairs:
        yield {**_of_camera(sensor, camera), **_of_plugin(sensor, plugin, side)}


def _side_of(camera: ElementTree.Element) -> str:
    """Return which of a stereo pair a <camera> is to libgazebo_ros_multicamera, '' for none."""
    return next((side for side in (_LEFT, _RIGHT) if side in name_of(camera)), '')


def not_simulated(sensor: ElementTree.Element, plugin: ElementTree.Element) -> List[str]:
    """Return what is not simulated of a camera that is."""
    found = [word for tag, word in _OTHER_TOPICS.items() if plugin.findtext(tag)]
    if any(_is_given(plugin, tag) for tag in _CLAIMED_DISTORTION):
        found.append('distortion by the plugin')
    for camera in sensor.findall('camera'):
        if sensor.get('type') == _WIDE and any(_is_given(camera, tag) for tag in _DISTORTION):
            found.append('distortion')
        if _format(camera) not in _ENCODINGS:
            found.append('format {}'.format(_format(camera)))
        if camera.find('lens/intrinsics') is not None:
            found.append('lens intrinsics')
        if sensor.get('type') == 'multicamera' and not _side_of(camera):
            found.append('camera {}, neither left nor right,'.format(name_of(camera)))
    return found


def _format(camera: ElementTree.Element) -> str:
    return text_of(camera, 'image/format') or 'R8G8B8'


def _is_given(owner: ElementTree.Element, path: str) -> bool:
    text = owner.findtext(path)
    return text is not None and abs(read_number('<{}>'.format(path), text)) > _MAX_IGNORED


def _of_camera(sensor: ElementTree.Element, camera: ElementTree.Element) -> Values:
    """Return the settings that a sensor and its camera give."""
    of = ' of sensor ' + name_of(sensor)
    is_wide = sensor.get('type') == _WIDE
    values: Values = {**_DEFAULTS, **_pose(sensor, camera, of)}
    noise = noises.read(camera.find('noise'), '<noise>' + of)
    if any(noise):
        values['camera_noise'], values['camera_noise_mean'] = noise.deviation, noise.mean
    if _format(camera) in _ENCODINGS:
        values['camera_encoding'] = _ENCODINGS[_format(camera)]
    if is_wide:
        values.update(_lens(camera, of))
    for path, setting in {**_NUMBERS, **(_LENS if is_wide else _DISTORTION)}.items():
        if text_of(camera, path):
            values[setting] = read_number('<{}>{}'.format(path, of), camera.findtext(path))
    for path, setting in {**_WHOLE_NUMBERS, **(_LENS_SIZE if is_wide else {})}.items():
        if text_of(camera, path):
            values[setting] = read_whole('<{}>{}'.format(path, of), camera.findtext(path))
    return values


def _pose(sensor: ElementTree.Element, camera: ElementTree.Element, of: str) -> Values:
    """Return where the camera is in the link: its pose is in the frame of the sensor."""
    poses = [read_numbers('<pose>' + of, pose.text, 6).tolist()
             for pose in (sensor.find('pose'), camera.find('pose')) if pose is not None]
    if len(poses) == 2:
        outer, inner = (transform(pose[:3], pose[3:]) for pose in poses)
        poses = [_numbers(outer @ inner)]
    return dict(zip(_POSE, poses[0])) if poses else {}


def _numbers(pose: Transform) -> List[float]:
    return [*pose.translation.tolist(), *rotations.to_rpy(pose.rotation).tolist()]


def _lens(camera: ElementTree.Element, of: str) -> Values:
    kind = text_of(camera, 'lens/type') or 'stereographic'
    if kind != lenses.CUSTOM:
        return {'camera_lens': kind, **_scale(camera, of)}
    if camera.find('lens/custom_function') is None:     # like Gazebo
        return {'camera_lens': 'stereographic', **_scale(camera, of)}
    values: Values = {'camera_lens': kind, **_scale(camera, of)}
    for path, setting in _CUSTOM.items():
        if camera.find(path) is not None:
            values[setting] = read_number('<{}>{}'.format(path, of), camera.findtext(path))
    function = text_of(camera, 'lens/custom_function/fun')
    return {**values, **({'camera_fun': function} if function else {})}


def _scale(camera: ElementTree.Element, of: str) -> Values:
    text = camera.findtext('lens/scale_to_hfov')
    return {} if text is None else {'camera_scale_to_hfov': _flag('<lens/scale_to_hfov>' + of,
                                                                  text)}


def _of_plugin(sensor: ElementTree.Element, plugin: ElementTree.Element, side: str) -> Values:
    """Return the settings that a plugin gives: rate, topics and frame; side: see `_side_of`."""
    of = ' of sensor ' + name_of(sensor)
    values: Values = dict(_names(plugin, sensor.get('type') == _DEPTH, side))
    rates = [read_number('<{}>{}'.format(tag, of), owner.findtext(tag))
             for owner, tag in ((plugin, 'updateRate'), (sensor, 'update_rate'))
             if owner.find(tag) is not None]
    # a rate of 0 means "as fast as possible" in Gazebo; here it leaves the default
    if any(rates):
        values['camera_rate'] = min(filter(None, rates))
    if side != _LEFT and plugin.find('hackBaseline') is not None:
        values['camera_baseline'] = read_number('<hackBaseline>' + of,
                                                plugin.findtext('hackBaseline'))
    if sensor.get('type') == _DEPTH:
        values.update(_depth(plugin, of))
        if 'gazebo_ros_depth_camera' in plugin.get('filename', ''):     # it has no upper limit
            del values['camera_points_max']
    return values


def _depth(plugin: ElementTree.Element, of: str) -> Iterator:
    for tag, setting, default in (('pointCloudCutoff', 'camera_points_min', '0.4'),
                                  ('pointCloudCutoffMax', 'camera_points_max', '5.0')):
        yield setting, read_number('<{}>{}'.format(tag, of), plugin.findtext(tag, default))
    is_short = plugin.findtext('useDepth16UC1Format', 'false')
    if _flag('<useDepth16UC1Format>' + of, is_short):
        yield 'camera_depth_encoding', '16UC1'


def _names(plugin: ElementTree.Element, has_depth: bool, side: str) -> Values:
    """Return the names of topics and of the frame that a plugin gives, and else its defaults."""
    def name(tag: str, default: str) -> str:
        return (plugin.findtext(tag) or '').strip() or default
    spaces = [name('robotNamespace', ''), name('cameraName', ''), side]
    folder = '/'.join(filter(None, (space.strip('/') for space in spaces)))

    def topic(tag: str, default: str) -> str:
        given = name(tag, default)
        # a name with a leading slash is not below that of the camera
        return '/'.join(filter(None, ('' if given.startswith('/') else folder, given.strip('/'))))
    kind = 'ir/' if has_depth else ''
    values: Values = {
        'camera_image_topic': topic('imageTopicName', kind + 'image_raw'),
        'camera_info_topic': topic('cameraInfoTopicName', kind + 'camera_info')}
    frame = name('frameName', '').strip('/')
    if frame:
        values['camera_optical_frame'] = frame
    if has_depth:
        values['camera_depth_topic'] = topic('depthImageTopicName', 'depth/image_raw')
        values['camera_depth_info_topic'] = topic('depthImageCameraInfoTopicName',
                                                  'depth/camera_info')
        values['camera_points_topic'] = topic('pointCloudTopicName', 'points')
    return values


def _flag(name: str, text: str) -> bool:
    word = text.strip().lower()
    if word not in ('true', 'false', '1', '0'):
        raise SimulationError('{}: got {!r}, expected true, false, 1 or 0'.format(name, text))
    return word in ('true', '1')
