"""Check the values of ./run demo's arguments like the nodes do; this needs the built package.

A node that refuses a value ends after the others have started, and roslaunch adds its own lines to
a file that it cannot load. The modules of the package are imported where they are needed: an
argument that is not given must not delay the start.
"""
import dataclasses

from img_recog.errors import UserError
from img_recog.messages import message

# arguments that have the name of a parameter
_PARAMETERS = ('image_width', 'image_height', 'framerate', 'pixel_format', 'camera_frame_id',
               'real_time_factor', 'x_pos', 'y_pos', 'z_pos', 'yaw', 'cmd_vel_timeout', 'view')


def check(words):
    """Raise UserError if a node would refuse one of the words NAME:=VALUE.

    words: as returned by Arguments.checked.
    """
    given = dict(word.split(':=', 1) for word in words if ':=' in word)
    for name, value in given.items():
        if name == 'colors':
            from img_recog.recognition import parameter_file
            parameter_file.read(value)
        elif name == 'urdf':
            from img_recog import robot_file
            robot_file.read(value)
        elif name in _PARAMETERS and (name, value) != ('real_time_factor', 'auto'):
            _check_setting(name, value)
        elif name.startswith('lockstep'):
            _check_lockstep(name, value, given)
    if given.get('camera') == 'robot':
        _check_robot_camera(given)
    if 'world' in given:
        from img_recog import resources, robot_file
        from img_recog.simulation.descriptions import world_file
        world_file.read(given['world'], resources.worlds(), resources.find,
                        given.get('allow_partial_world', '').lower() in ('1', 'true'),
                        read_file=robot_file.read_any)


def _check_setting(name, value):
    from img_recog.camera.settings import CameraSettings
    from img_recog.simulation import settings
    for settings_class in (CameraSettings, settings.PhysicsSettings, settings.SpawnSettings,
                           settings.DriveSettings, settings.ViewSettings):
        if name in (field.name for field in dataclasses.fields(settings_class)):
            settings_class(**{name: _typed(value)})


def _check_lockstep(name, value, given):
    from img_recog.nodes.gazebo.lockstep_settings import LockstepSettings
    settings = LockstepSettings(**{name: _typed(value)})
    if name == 'lockstep' and not settings.topics:
        return
    if given.get('simulator', '').lower() in ('0', 'false'):
        raise UserError(
            message('{}: it is the simulator that waits, and simulator is false', name),
            message('set simulator to true, or leave out {}', name))


def _check_robot_camera(given):
    if given.get('simulator', '').lower() in ('0', 'false'):
        raise UserError(
            message('camera: got robot, which is simulated, and simulator is false'),
            message('set simulator to true, or camera to none for the camera of a real robot'))
    from img_recog.simulation.settings import CameraSettings
    for name, setting in (('image_width', 'camera_width'), ('image_height', 'camera_height'),
                          ('framerate', 'camera_rate')):
        if name in given:
            CameraSettings(**{setting: _typed(given[name])})


def _typed(value):
    """Return a value with the type that roslaunch gives it."""
    for number in (int, float):
        try:
            return number(value)
        except ValueError:
            continue
    return value
