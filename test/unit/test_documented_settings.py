"""The settings have the defaults and limits that doc/reference.md states."""
import re

import pytest
from img_recog_helpers.pages import read, rows

from img_recog.camera import usb_cam_settings as camera
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.nodes.gazebo.lockstep_settings import LockstepSettings
from img_recog.nodes.gazebo.robot_reader import robot_settings_classes
from img_recog.nodes.gazebo.stepping import SteppingSettings
from img_recog.recognition.recognition_settings import with_colors
from img_recog.settings import SettingError, setting_fields
from img_recog.simulation import simulation_settings as simulation
from img_recog.teleoperation.teleop_settings import TeleopSettings

CLASSES = {
    'usb_cam': (camera.UsbCamSettings, camera.ControlSettings, CompressionSettings),
    'color_extract': (with_colors(),),
    'gazebo': (simulation.PhysicsSettings, simulation.ViewSettings, LockstepSettings,
               SteppingSettings, *robot_settings_classes()),
    'turtlebot3_teleop_keyboard': (TeleopSettings,)}


def parts(cells):
    """Return name, default and allowed values of each parameter of a row."""
    names, defaults = cells[0].split(', '), cells[1].split('`, `')
    if len(defaults) < len(names):      # the row has one for all of them
        defaults = [cells[1]] * len(names)
    return [(name.strip('`'), default, cells[2]) for name, default in zip(names, defaults)]


ROWS = {(node, name): values for node in CLASSES
        for row in rows(read('doc/reference.md'), node, 'name') for name, *values in parts(row)}
FIELDS = [pytest.param(settings_class, field, *ROWS[node, field.name],
                       id='{}-{}'.format(node, field.name))
          for node, classes in CLASSES.items() for settings_class in classes
          for field in setting_fields(settings_class)]
# of floats, relative: far below every step between two documented numbers
TINY = 1e-5


def accepts(settings_class, name, value):
    # the highest value of a color must not be below its lowest
    others = {name[:-3] + 'min': 0} if re.search('(saturation|value|column)_max$', name) else {}
    # nor the farthest distance below the nearest
    others.update({'camera_near': {'camera_far': 1e4}, 'camera_far': {'camera_near': 1e-3},
                   'camera_horizontal_fov': {'camera_lens': 'equidistant'}}.get(name, {}))
    try:
        return getattr(settings_class(**{name: value}, **others), name) == value
    except SettingError as refused:
        assert refused.name == name
        return False


@pytest.mark.parametrize('settings_class, field, default, allowed', FIELDS)
def test_defaults_and_limits_are_those_of_the_page(settings_class, field, default, allowed):
    name, kind = field.name, field.metadata['kind']
    value = getattr(settings_class(), name)
    assert type(value) is kind
    assert ((str(value).lower() if kind is bool else str(value)) or 'empty') == default.strip('`')

    def step(limit, sign):
        return limit + sign * (1 if kind is int else TINY * max(abs(limit), TINY))

    for low in re.findall(r'(?:from|at least) ([-\d.e]+)', allowed):
        low = kind(low)
        # pi is rounded on the page
        inside = step(low, +1) if name == 'yaw' else low
        assert accepts(settings_class, name, inside), low
        assert accepts(settings_class, name, step(low, -1)) is (name == 'real_time_factor' and
                                                                step(low, -1) == 0)
    for high in re.findall(r' to ([-\d.e]+)', allowed):
        high = kind(high)
        assert accepts(settings_class, name, step(high, -1) if name == 'yaw' else high), high
        assert not accepts(settings_class, name, step(high, +1)), high
    for low in re.findall(r'above ([-\d.e]+)', allowed):
        assert not accepts(settings_class, name, kind(low))
        assert accepts(settings_class, name, step(kind(low), +1)), low
    if 'non-empty' in allowed:
        assert accepts(settings_class, name, 'x') and not accepts(settings_class, name, ' ')
    for choice in allowed[len('one of '):].split(', ') if 'one of' in allowed else ():
        assert accepts(settings_class, name, choice)
    if 'one of' in allowed:
        assert not accepts(settings_class, name, 'x')


@pytest.mark.parametrize('settings_class', [each for classes in CLASSES.values()
                                            for each in classes])
def test_settings_cannot_be_changed(settings_class):
    field = next(setting_fields(settings_class))
    with pytest.raises(AttributeError):
        setattr(settings_class(), field.name, getattr(settings_class(), field.name))
