"""Settings: the values that each field accepts, and the error messages for others."""
import dataclasses
import math
from typing import Any, ClassVar

import pytest
import yaml

from img_recog.camera.usb_cam_settings import UsbCamSettings, intrinsic_controls
from img_recog.settings import (SettingError, Settings, above, at_least, between, clamped,
                                from_mapping, not_empty, one_of, setting, setting_fields,
                                unknown)
from img_recog.simulation.simulation_settings import REAL_TIME_FACTORS
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal


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


class _Loader(yaml.SafeLoader):
    """Reads bytes as bytes, even if rosparam, which changes SafeLoader, was imported."""


_Loader.add_constructor('tag:yaml.org,2002:binary', yaml.SafeLoader.construct_yaml_binary)


def test_error_names_field_value_and_allowed_values():
    expected.check_cases('refused/settings.txt',
                         lambda text: refusal(Sample, **yaml.load(text, Loader=_Loader)))
    with pytest.raises(SettingError) as refused:
        Sample(width=801)
    error = refused.value
    assert (error.name, error.value, error.allowed) == (
        'width', 801, 'a whole number from 1 to 800')


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


def test_setting_fields_yields_the_fields_made_by_setting_in_order():
    assert [field.name for field in setting_fields(Sample)] == [
        'width', 'count', 'rate', 'enabled', 'mode', 'name', 'note']


@pytest.mark.parametrize('name', [
    '../../evil', 'a/b', '/a', '.', '..', '', ' ', 'a\n', 'a\0'])
def test_camera_names_that_could_be_paths_are_refused(name):
    with pytest.raises(SettingError, match='^camera_name: got .*, allowed is a name '
                       'without / and control characters$'):
        UsbCamSettings(camera_name=name)


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


@pytest.mark.parametrize('factor, is_one', [
    (0, True), (0.001, True), (1000, True), (-1, False), (0.0009, False), (1000.1, False)])
def test_factors_of_real_time(factor, is_one):
    assert REAL_TIME_FACTORS.accepts(factor) is is_one


def test_a_large_bound_is_written_out():
    assert between(0, 2 ** 31 - 1).text == 'from 0 to 2147483647'
    assert between(-0.5, 1e-5).text == 'from -0.5 to 1e-05'


@dataclasses.dataclass(frozen=True)
class LikeRoscpp(Settings):
    """One field of each kind, read like roscpp's getParam."""

    is_like_roscpp: ClassVar[bool] = True
    quality: int = setting(80, clamped(1, 100))
    width: int = setting(640, between(1, 800))
    rate: float = setting(30.0, above(0))
    flag: bool = setting(True)
    name: str = setting('camera')


@pytest.mark.parametrize('name, value, used', [
    ('quality', 200, 100), ('quality', 75.6, 76), ('quality', 75.5, 76), ('quality', 75.4, 75),
    ('quality', 0, 1), ('quality', '75', 80), ('quality', True, 80), ('quality', [75], 80),
    ('quality', -0.4, 1), ('quality', math.nan, 1), ('quality', 1e10, 1),
    ('quality', -math.inf, 1),
    ('width', 639.5, 640), ('width', '320', 640), ('width', 320.0, 320),
    ('rate', 15, 15.0), ('rate', '1e1', 10.0), ('rate', False, 30.0), ('rate', [1.0], 30.0),
    ('flag', 0, True), ('flag', 0.0, True), ('flag', 'false', True), ('flag', False, False),
    ('name', 5, 'camera'), ('name', 1.5, 'camera'), ('name', {'a': 1}, 'camera'),
    ('name', '', '')])
def test_values_are_read_like_roscpp(name, value, used):
    read = getattr(from_mapping(LikeRoscpp, {name: value}), name)
    assert (read, type(read)) == (used, type(used))


@pytest.mark.parametrize('name, value', [('width', 801), ('width', 1e10), ('width', math.nan),
                                         ('rate', 0), ('rate', 'fast')])
def test_what_roscpp_reads_is_checked_too(name, value):
    with pytest.raises(SettingError, match='^{}: got '.format(name)):
        from_mapping(LikeRoscpp, {name: value})
