"""Check the values of ./run demo's arguments like the nodes do; this needs the built package.

A node that refuses a value ends after the others have started, and roslaunch adds its own lines to
a file that it cannot load.
"""
import importlib

# arguments that have the name of a parameter: the settings with this parameter
_SETTINGS = {'camera.settings.CameraSettings': ('image_width', 'image_height', 'framerate',
                                                'pixel_format', 'camera_frame_id'),
             'simulation.settings.PhysicsSettings': ('real_time_factor',),
             'simulation.settings.SpawnSettings': ('x_pos', 'y_pos', 'z_pos', 'yaw'),
             'simulation.settings.DriveSettings': ('cmd_vel_timeout',),
             'simulation.settings.ViewSettings': ('view',)}


def check(words):
    """Raise img_recog.errors.UserError if a node would refuse one of the words NAME:=VALUE.

    words: as returned by Arguments.checked.
    """
    given = dict(word.split(':=', 1) for word in words if ':=' in word)
    for name, value in given.items():
        _check(name, value)
    if given.get('camera') == 'robot':
        _check_robot_camera(given)
    if 'world' in given:
        resources = _module('resources')
        _module('simulation.descriptions.world_file').read(
            given['world'], resources.worlds(), resources.find,
            given.get('allow_partial_world', '').lower() in ('1', 'true'))


def _check_robot_camera(given):
    if given.get('simulator', '').lower() in ('0', 'false'):
        raise _module('errors').UserError(
            'camera: got robot, which is simulated, and simulator is false',
            'set simulator to true, or camera to none for the camera of a real robot')
    settings = _module('simulation.settings').CameraSettings
    for name, setting in (('image_width', 'camera_width'), ('image_height', 'camera_height'),
                          ('framerate', 'camera_rate')):
        if name in given:
            settings(**{setting: _typed(given[name])})


def _check(name, value):
    if name == 'colors':
        _module('recognition.parameter_file').read(value)
    elif name == 'urdf' and value.endswith('.xacro'):
        _module('robot_file').read(value)
    for path, names in _SETTINGS.items():
        if name in names:
            module, _, settings_class = path.rpartition('.')
            getattr(_module(module), settings_class)(**{name: _typed(value)})


def _module(path):
    return importlib.import_module('img_recog.' + path)


def _typed(value):
    """Return a value with the type that roslaunch gives it."""
    for number in (int, float):
        try:
            return number(value)
        except ValueError:
            continue
    return value
