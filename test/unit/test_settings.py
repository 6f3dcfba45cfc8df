"""Settings: the values that each field accepts, and the error messages for others."""
import dataclasses
from typing import Any

import pytest

from img_recog.camera.settings import CameraSettings, ControlSettings, intrinsic_controls
from img_recog.errors import UserError
from img_recog.settings import (SettingError, Settings, above, at_least, between, not_empty,
                                one_of, setting, setting_fields, unknown)
from img_recog.teleoperation.settings import TeleopSettings


@dataclasses.dataclass(frozen=True)
class Sample(Settings):
    """One field of each type."""

    width: int = setting(640, between(1, 800))
    count: int = setting(0, at_least(0))
    rate: float = setting(30.0, above(0))
    enabled: bool = setting(True)
    mode: str = setting('slow', one_of('slow', 'fast'))
    name: str = setting('sample', not_empty())
    note: str = setting('')
    unchecked: Any = None


@pytest.mark.parametrize('name, value, kept', [
    *((name, value, value) for name, value in (
        ('width', 1), ('width', 800), ('count', 0), ('count', 2 ** 31 - 1), ('rate', 1e-9),
        ('enabled', False), ('mode', 'fast'), ('name', 'x'), ('note', ''),
        ('unchecked', object))),
    ('rate', 25, 25.0), ('width', 320.0, 320),
    ('rate', '1e-1', 0.1)])         # YAML does not read it as a number
def test_allowed_value_is_kept_in_the_type_of_the_field(name, value, kept):
    got = getattr(Sample(**{name: value}), name)
    assert got == kept and type(got) is type(kept)


def test_defaults_without_arguments():
    assert dataclasses.astuple(Sample()) == (640, 0, 30.0, True, 'slow', 'sample', '', None)


@pytest.mark.parametrize('name, value, allowed', [
    ('count', 10 ** 12, 'a whole number at least 0, within 32 bits'),
    ('count', 1e12, 'a whole number at least 0'),
    ('rate', 10 ** 199, 'a finite number above 0, within 32 bits'),
    ('width', 0, 'a whole number from 1 to 800'),
    ('width', 801, 'a whole number from 1 to 800'),
    ('width', 640.5, 'a whole number from 1 to 800'),
    ('width', '640', 'a whole number from 1 to 800'),
    ('width', True, 'a whole number from 1 to 800'),
    ('width', None, 'a whole number from 1 to 800'),
    ('count', -1, 'a whole number at least 0'),
    ('rate', 0.0, 'a finite number above 0'),
    ('rate', -0.5, 'a finite number above 0'),
    ('rate', float('nan'), 'a finite number above 0'),
    ('rate', float('inf'), 'a finite number above 0'),
    ('rate', True, 'a finite number above 0'),
    ('rate', '30 Hz', 'a finite number above 0'),
    ('rate', [30.0], 'a finite number above 0'),
    ('enabled', 1, 'true or false'),
    ('enabled', 0.0, 'true or false'),
    ('enabled', 'true', 'true or false'),
    ('mode', 'medium', 'one of slow, fast'),
    ('mode', 'slo', 'one of slow, fast'),
    ('name', '', 'a non-empty string'),
    ('name', ' \n', 'a non-empty string'),
    ('note', 5, 'a string'),
    ('note', b'bytes', 'a string')])
def test_error_names_field_value_and_allowed_values(name, value, allowed):
    with pytest.raises(SettingError) as refused:
        Sample(**{name: value})
    got = 'nothing' if value is None else repr(value)
    assert str(refused.value) == '{}: got {}, allowed is {}'.format(name, got, allowed)
    assert '\n' not in str(refused.value)
    assert (refused.value.name, refused.value.allowed) == (name, allowed)
    assert refused.value.value is value
    assert isinstance(refused.value, UserError)


def test_a_value_of_8_mb_and_a_hostile_name_are_shortened():
    with pytest.raises(SettingError) as refused:
        Sample(mode='\x1b' * (8 << 20))
    assert len(str(refused.value)) < 300 and str(refused.value).isprintable()
    line = unknown('x\n[FATAL] forged\x1b[2J' + 'y' * (8 << 20), ['rate'], '')
    assert len(line) < 300 and r'x\n[FATAL] forged\x1b[2J' in line


def test_replacing_a_field_checks_it_again():
    with pytest.raises(SettingError, match='^width: got 9999'):
        dataclasses.replace(Sample(), width=9999)
    assert dataclasses.replace(Sample(), width=7).width == 7


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Sample().width = 320


def test_setting_fields_yields_the_fields_made_by_setting_in_order():
    assert [field.name for field in setting_fields(Sample)] == [
        'width', 'count', 'rate', 'enabled', 'mode', 'name', 'note']


def test_camera_defaults_are_those_of_usb_cam():
    assert dataclasses.asdict(CameraSettings()) == {
        'video_device': '/dev/video0', 'io_method': 'mmap', 'pixel_format': 'mjpeg',
        'image_width': 640, 'image_height': 480, 'framerate': 30.0,
        'camera_frame_id': 'head_camera', 'camera_name': 'head_camera', 'camera_info_url': '',
        'create_suspended': False, 'loop': True, 'max_image_pixels': 50000000}


@pytest.mark.parametrize('kind, name, value, allowed', [
    (CameraSettings, 'video_device', '', ''), (CameraSettings, 'io_method', 'dma', ''),
    (CameraSettings, 'pixel_format', 'yuv',
     'one of grey, mjpeg, rgb24, uyvy, yuvmono10, yuyv'),
    (CameraSettings, 'image_width', 0, ''), (CameraSettings, 'image_height', 16385, ''),
    (CameraSettings, 'framerate', 0.05, ''), (CameraSettings, 'framerate', 0, ''),
    (CameraSettings, 'camera_frame_id', '', ''),
    *((CameraSettings, 'camera_name', name, 'a name of letters, digits and _') for name in (
        '../../evil', 'a/b', 'a.b', 'a b', '/a', '..', '', ' ', 'a\n', '${ROS_HOME}', 'caf\u00e9',
        'a:b', '~a', 'a\0')),      # they could be paths
    *((CameraSettings, 'max_image_pixels', value, 'a whole number from 1 to 268435456')
      for value in (0, -1, (1 << 28) + 1, 5e7 + 0.5, '9', True)),
    *((TeleopSettings, name, 0, 'a finite number above 0') for name in (
        'linear_step', 'angular_step', 'max_linear_velocity', 'max_angular_velocity'))])
def test_values_that_nodes_refuse(kind, name, value, allowed):
    with pytest.raises(SettingError, match='^{}: got .*, allowed is {}'.format(name, allowed)):
        kind(**{name: value})


def test_control_defaults_are_those_of_usb_cam():
    assert dataclasses.asdict(ControlSettings()) == {
        'brightness': -1, 'contrast': -1, 'saturation': -1, 'sharpness': -1, 'gain': -1,
        'autofocus': False, 'focus': -1, 'autoexposure': True, 'exposure': 100,
        'auto_white_balance': True, 'white_balance': 4000}


@pytest.mark.parametrize('given, values', [
    ({}, {}), ({'gain': 5, 'focus_auto': True}, {'gain': 5, 'focus_auto': 1}),
    ({'gain': 5, 'hue': 3, 'ignore': ['hue']}, {'gain': 5})])
def test_intrinsic_controls(given, values):
    assert intrinsic_controls(given) == values


@pytest.mark.parametrize('given', [5, 'gain', [1], {'gain': 'much'}, {'gain': 0.5},
                                   {'gain': None}, {'ignore': 'gain'}])
def test_intrinsic_controls_refuses(given):
    with pytest.raises(SettingError, match='^intrinsic_controls: got .* allowed is a map of V4L2'):
        intrinsic_controls(given)


def test_teleop_defaults_are_those_of_the_burger():
    assert dataclasses.asdict(TeleopSettings()) == {
        'linear_step': 0.01, 'angular_step': 0.1,
        'max_linear_velocity': 0.22, 'max_angular_velocity': 2.84}


def test_a_large_bound_is_written_out():
    assert between(0, 2 ** 31 - 1).text == 'from 0 to 2147483647'
    assert between(-0.5, 1e-5).text == 'from -0.5 to 1e-05'
