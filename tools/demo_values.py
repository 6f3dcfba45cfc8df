"""Check the values of ./run demo's arguments like the nodes do; this needs the built package.

A node that refuses a value ends after the others have started, and roslaunch adds its own lines to
a file that it cannot load. The modules of the package are imported where they are needed: an
argument that is not given must not delay the start.
"""
import dataclasses

from img_recog.command_line.messages import message
from img_recog.errors import UserError
from img_recog.settings import Settings, at_least, from_mapping, setting, setting_fields

# arguments that have the name of a parameter
_PARAMETERS = {'image_width', 'image_height', 'framerate', 'pixel_format', 'camera_frame_id',
               'real_time_factor', 'x_pos', 'y_pos', 'z_pos', 'yaw', 'cmd_vel_timeout', 'view',
               'web_host', 'web_port', 'record_size'}
_TRUE, _FALSE = ('1', 'true'), ('0', 'false')


@dataclasses.dataclass(frozen=True)
class _RecordSettings(Settings):
    """What rosbag is given: MB, 0 for no limit."""

    record_size: int = setting(2000, at_least(0))


def check(words):
    """Raise UserError if a node would refuse one of the words NAME:=VALUE.

    words: as returned by Arguments.checked.
    """
    given = dict(word.split(':=', 1) for word in words if ':=' in word)
    if not _PARAMETERS.isdisjoint(given):
        _check_parameters(given)
    if 'colors' in given:
        from img_recog.recognition import parameter_file
        parameter_file.read(given['colors'])
    if 'urdf' in given:
        from img_recog.loading import robot_file
        robot_file.read(given['urdf'])
    for name in sorted(given):
        if name.startswith('lockstep'):
            _check_lockstep(name, given)
    if given.get('robots', 'none') != 'none':
        from img_recog.loading import resources
        from img_recog.nodes.robots import robot_list
        robot_list.read_robots(given['robots'], vars(_settings(robot_list.NodeSettings, given)),
                               resources.find)
    if given.get('camera') == 'robot':
        _check_robot_camera(given)
    if 'world' in given:
        from img_recog.loading import resources, robot_file
        from img_recog.formats import world_file
        world_file.read(given['world'], resources.worlds(), resources.find,
                        given.get('allow_partial_world', '').lower() in _TRUE,
                        read_file=robot_file.read_any)


def _check_parameters(given):
    from img_recog.camera.usb_cam_settings import UsbCamSettings
    from img_recog.nodes.web.web_settings import WebSettings
    from img_recog.simulation.simulation_settings import (DriveSettings, PhysicsSettings,
                                                          SpawnSettings, ViewSettings)
    for settings_class in (UsbCamSettings, PhysicsSettings, SpawnSettings, DriveSettings,
                           ViewSettings, WebSettings, _RecordSettings):
        _settings(settings_class, given)


def _check_lockstep(name, given):
    from img_recog.nodes.gazebo.lockstep_settings import LockstepSettings
    settings = _settings(LockstepSettings, {name: given[name]})
    if name == 'lockstep' and not settings.topics:
        return
    if given.get('simulator', '').lower() in _FALSE:
        raise UserError(
            message('{}: it is the simulator that waits, and simulator is false', name),
            message('set simulator to true, or leave out {}', name))


def _check_robot_camera(given):
    if given.get('simulator', '').lower() in _FALSE:
        raise UserError(
            message('camera: got robot, which is simulated, and simulator is false'),
            message('set simulator to true, or camera to none for the camera of a real robot'))
    from img_recog.simulation.simulation_settings import CameraSettings
    _settings(CameraSettings, {
        setting: given[name] for name, setting in (
            ('image_width', 'camera_width'), ('image_height', 'camera_height'),
            ('framerate', 'camera_rate')) if name in given})


def _settings(settings_class, given):
    """Return settings of the texts that are given, with the types that roslaunch gives them."""
    return from_mapping(settings_class, {
        field.name: _typed(given[field.name], type(field.default))
        for field in setting_fields(settings_class) if field.name in given})


def _typed(value, kind):
    if kind is bool:
        return value.lower() in _TRUE
    try:
        return value if kind is str else float(value) if '.' in value else int(value)
    except ValueError:
        return value
