"""What tools/demo_values.py refuses: what a node would refuse, in its words."""
import importlib
import os

import pytest

from img_recog_helpers.pages import ROOT, launch_arguments
from img_recog_helpers.refusals import refusal

ARGUMENTS = [(each.name, each.default) for each in launch_arguments().values()]


@pytest.fixture
def check(monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(ROOT, 'tools'))
    return importlib.import_module('demo_values').check


def is_number(text):
    try:
        return float(text) == float(text)
    except ValueError:
        return False


@pytest.mark.parametrize('name', [name for name, default in ARGUMENTS if is_number(default)])
@pytest.mark.parametrize('value', ['x', 'nan', '', '99999999999'])
def test_no_number(check, name, value):
    assert refusal(check, ['{}:={}'.format(name, value)]).startswith(name + ': got ')


@pytest.mark.parametrize('words, problem', [
    (['web_port:=80.5'], 'web_port: got 80.5, allowed is a whole number from 1 to 65535'),
    (['web_port:=0'], 'web_port: got 0, allowed is a whole number from 1 to 65535'),
    (['web_host:='], "web_host: got '', allowed is a non-empty string"),
    (['record_size:=1.5'], 'record_size: got 1.5, allowed is a whole number at least 0'),
    (['image_width:=6e2'], "image_width: got '6e2', allowed is a whole number from 1 to 16384"),
    (['robots:=0'], 'robots: got 0, allowed is a number from 1 to 100, or the path of a YAML '),
    (['robots:=-1'], 'robots: got -1, allowed is '),
    (['robots:=/no.yaml'], 'robots: cannot read /no.yaml: No such file or directory; give '),
    (['colors:=/no.yaml'], 'cannot read the parameters in /no.yaml: No such file or directory'),
    (['urdf:=/no.urdf'], 'cannot read the robot in /no.urdf: No such file or '),
    (['world:=no.sdf'], "world: got 'no.sdf', which cannot be read as a file ("),
    (['world:='], "world: got '', which cannot be read as a file ("),
    (['pixel_format:=x'], "pixel_format: got 'x', allowed is one of "),
    (['view:=x'], "view: got 'x', allowed is one of "),
    (['real_time_factor:=-1'], 'real_time_factor: got -1.0, allowed is '),
    (['cmd_vel_timeout:=-1'], 'cmd_vel_timeout: got -1.0, allowed is a finite number at least 0'),
    (['x_pos:=1e9'], 'x_pos: got 1000000000.0, allowed is a finite number from -1000 to 1000'),
    (['lockstep_sensors:=sonar'],
     "lockstep_sensors: got 'sonar', allowed is some of image, scan"),
    (['camera:=robot', 'image_width:=8000'], 'camera_width: got 8000, allowed is a whole number '),
    (['robots:=2', 'image_width:=8000'], 'image_width: got 8000, allowed is a whole number from '
                                         '1 to 4096')])
def test_refused(check, words, problem):
    assert refusal(check, words).startswith(problem)


@pytest.mark.parametrize('words', [
    ['{}:={}'.format(name, default) for name, default in ARGUMENTS if '$(' not in default],
    # texts that look like numbers; numbers as roslaunch reads them
    ['camera_frame_id:=5', 'web_host:=1', 'x_pos:=-1e-3', 'yaw:=3', 'image_width:=64.0'],
    ['robots:=3', 'recognition:=1', 'safe:=False', 'camera:=none'],
    ['real_time_factor:=0', 'allow_partial_world:=1']])
def test_accepted(check, words):
    check(words)
