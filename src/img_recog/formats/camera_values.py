"""The settings of a camera that SDF's <sensor> and the plugins of gazebo_plugins give."""
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterator, List, Mapping, Optional

from img_recog import rotations
from img_recog.formats import lenses, noises
from img_recog.formats.reader import is_true, name_of, read, value
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
# paths in <camera> and their settings
_CAMERA = {'image/width': 'camera_width', 'image/height': 'camera_height',
           'horizontal_fov': 'camera_horizontal_fov', 'clip/near': 'camera_near',
           'clip/far': 'camera_far'}
# of <image><format>, as libgazebo_ros_camera names them
_ENCODINGS = {'R8G8B8': 'rgb8', 'RGB_INT8': 'rgb8', 'B8G8R8': 'bgr8', 'BGR_INT8': 'bgr8',
              'L8': 'mono8', 'L_INT8': 'mono8'}
_DISTORTION = {'distortion/' + name: 'camera_' + name for name in ('k1', 'k2', 'k3', 'p1', 'p2')}
_SCALE = {'lens/scale_to_hfov': 'camera_scale_to_hfov'}
_LENS = {'lens/cutoff_angle': 'camera_cutoff_angle',
         'lens/env_texture_size': 'camera_env_texture_size'}
_CUSTOM = {'lens/custom_function/' + name: 'camera_' + name
           for name in ('c1', 'c2', 'c3', 'f', 'fun')}
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
        if value(camera, 'image/format') not in _ENCODINGS:
            found.append('format {}'.format(value(camera, 'image/format')))
        if camera.find('lens/intrinsics') is not None:
            found.append('lens intrinsics')
        if sensor.get('type') == 'multicamera' and not _side_of(camera):
            found.append('camera {}, neither left nor right,'.format(name_of(camera)))
    return found


def _is_given(owner: ElementTree.Element, path: str) -> bool:
    text = owner.findtext(path)
    return text is not None and abs(read('number', text, '<{}>'.format(path))) > _MAX_IGNORED


def _of_camera(sensor: ElementTree.Element, camera: ElementTree.Element) -> Values:
    """Return the settings that a sensor and its camera give."""
    owner = 'sensor ' + name_of(sensor)
    is_wide = sensor.get('type') == _WIDE
    values = {**_values(camera, _CAMERA, owner), **_pose(sensor, camera, owner)}
    noise = noises.read(camera.find('noise'), '<noise> of ' + owner)
    if any(noise):
        values['camera_noise'], values['camera_noise_mean'] = noise.deviation, noise.mean
    encoding = _ENCODINGS.get(value(camera, 'image/format'))
    if encoding:
        values['camera_encoding'] = encoding
    values.update(_values(camera, _lens(camera, values) if is_wide else _DISTORTION, owner))
    return values


def _values(camera: ElementTree.Element, paths: Mapping[str, str], owner: str) -> Values:
    """Return the values at some paths, by their settings, but for those that are not given."""
    found = {setting: value(camera, path, owner) for path, setting in paths.items()}
    return {setting: each for setting, each in found.items() if each is not None}


def _pose(sensor: ElementTree.Element, camera: ElementTree.Element, owner: str) -> Values:
    """Return where the camera is in the link: its pose is in the frame of the sensor."""
    poses = [read('6numbers', pose.text, '<pose> of ' + owner).tolist()
             for pose in (sensor.find('pose'), camera.find('pose')) if pose is not None]
    if len(poses) == 2:
        outer, inner = (transform(pose[:3], pose[3:]) for pose in poses)
        poses = [_numbers(outer @ inner)]
    return dict(zip(_POSE, poses[0])) if poses else {}


def _numbers(pose: Transform) -> List[float]:
    return [*pose.translation.tolist(), *rotations.to_rpy(pose.rotation).tolist()]


def _lens(camera: ElementTree.Element, values: Values) -> Dict[str, str]:
    """Set the type of a lens, and return the paths of what else it has, with their settings."""
    kind = value(camera, 'lens/type')
    if kind == lenses.CUSTOM and camera.find('lens/custom_function') is None:
        kind = 'stereographic'          # as in Gazebo
    values['camera_lens'] = kind
    return {**_SCALE, **(_CUSTOM if kind == lenses.CUSTOM else {}), **_LENS}


def _of_plugin(sensor: ElementTree.Element, plugin: ElementTree.Element, side: str) -> Values:
    """Return the settings that a plugin gives: rate, topics and frame; side: see `_side_of`."""
    name = 'sensor ' + name_of(sensor)
    values: Values = dict(_names(plugin, sensor.get('type') == _DEPTH, side))
    rates = [read('number', owner.findtext(tag), '<{}> of {}'.format(tag, name))
             for owner, tag in ((plugin, 'updateRate'), (sensor, 'update_rate'))
             if owner.find(tag) is not None]
    # a rate of 0 means "as fast as possible" in Gazebo; here it leaves the default
    if any(rates):
        values['camera_rate'] = min(filter(None, rates))
    if side != _LEFT and plugin.find('hackBaseline') is not None:
        values['camera_baseline'] = read('number', plugin.findtext('hackBaseline'),
                                         '<hackBaseline> of ' + name)
    if sensor.get('type') == _DEPTH:
        values.update(_depth(plugin, name))
        if 'gazebo_ros_depth_camera' in plugin.get('filename', ''):     # it has no upper limit
            del values['camera_points_max']
    return values


def _depth(plugin: ElementTree.Element, name: str) -> Iterator:
    for tag, setting, default in (('pointCloudCutoff', 'camera_points_min', '0.4'),
                                  ('pointCloudCutoffMax', 'camera_points_max', '5.0')):
        yield setting, read('number', plugin.findtext(tag, default),
                            '<{}> of {}'.format(tag, name))
    if is_true(plugin.findtext('useDepth16UC1Format')):
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
