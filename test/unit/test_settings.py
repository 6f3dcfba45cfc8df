"""Settings: the values that each field accepts, and the error messages for others."""
import dataclasses
from typing import Any

import pytest
import yaml

from img_recog.camera.usb_cam_settings import UsbCamSettings, intrinsic_controls
from img_recog.settings import (SettingError, Settings, above, at_least, between, not_empty,
                                one_of, setting, setting_fields, unknown)
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


def test_error_names_field_value_and_allowed_values():
    expected.check_cases('refused/settings.txt',
                         lambda text: refusal(Sample, **yaml.safe_load(text)))
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
