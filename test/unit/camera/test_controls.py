"""V4L2 controls of a fake device: the values that are set, their order, and the problems."""
import errno
import os
import struct

import pytest

from img_recog.camera import controls
from img_recog.camera.controls import Control, ControlDevice, apply, variable_name
from img_recog.camera.usb_cam_settings import ControlSettings
from img_recog.settings import unknown
from img_recog_helpers.descriptors import times_open


class FakeDevice:
    """A camera with the given controls; records the values that are set."""

    def __init__(self, *control_ids, low=0, high=255, settable=True, values=(), names=None,
                 refused=None):
        self._controls = [Control(each, (names or NAMES)[each], low, high, 1, 0, settable)
                          for each in control_ids]
        self.values, self.done, self.refused = dict(values), [], refused

    def controls(self):
        return self._controls

    def get(self, control_id):
        value = self.values.get(control_id, 0)
        if isinstance(value, OSError):
            raise value
        return value

    def set(self, control_id, value):
        if self.refused is not None:
            raise self.refused
        self.done.append((control_id, value))


NAMES = {0x00980903: 'hue', **{
    control_id: name for name, control_id in controls.KNOWN_NAMES.items()}}
ALL = sorted(NAMES)
BRIGHTNESS, CONTRAST, GAIN = (
    controls.KNOWN_NAMES[name] for name in ('brightness', 'contrast', 'gain'))


@pytest.mark.parametrize('name, control_id, meant', [      # linux/v4l2-controls.h
    ('brightness', 0x00980900, ''), ('contrast', 0x00980901, ''), ('saturation', 0x00980902, ''),
    ('white_balance_automatic', 0x0098090c, 'auto_white_balance'),
    ('white_balance_temperature_auto', 0x0098090c, 'auto_white_balance'), ('gain', 0x00980913, ''),
    ('white_balance_temperature', 0x0098091a, 'white_balance'), ('sharpness', 0x0098091b, ''),
    ('auto_exposure', 0x009a0901, 'autoexposure'), ('exposure_auto', 0x009a0901, 'autoexposure'),
    ('exposure_time_absolute', 0x009a0902, 'exposure'),
    ('exposure_absolute', 0x009a0902, 'exposure'), ('focus_absolute', 0x009a090a, 'focus'),
    ('focus_automatic_continuous', 0x009a090c, 'autofocus'),
    ('focus_auto', 0x009a090c, 'autofocus')])
def test_ids_are_those_of_the_kernel_and_names_those_that_a_setting_is_meant_with(
        name, control_id, meant):
    assert controls.KNOWN_NAMES[name] == control_id
    device = FakeDevice(control_id, names={control_id: 'any'})
    assert apply(device, ControlSettings(autofocus=True), {name: 1})[1:] == []
    assert (control_id, 1) in device.done
    line = unknown(name, vars(ControlSettings()), meant=controls.SETTINGS)
    assert not meant or line.endswith('did you mean {}?'.format(meant))


def test_settings_have_the_ids_of_the_kernel():
    device = FakeDevice(*ALL, high=9000)
    apply(device, ControlSettings(
        brightness=11, contrast=12, saturation=13, sharpness=14, gain=15, autofocus=False,
        focus=16, autoexposure=False, exposure=17, auto_white_balance=False, white_balance=18), {})
    assert device.done == [
        (0x00980900, 11), (0x00980901, 12), (0x00980902, 13), (0x0098091b, 14), (0x00980913, 15),
        (0x0098090c, 0), (0x0098091a, 18), (0x009a0901, 1), (0x009a0902, 17), (0x009a090c, 0),
        (0x009a090a, 16)]


NOT_THERE = 'the camera has no control {}; v4l2-ctl --list-ctrls lists its controls'.format
DEFAULTS = [(controls.AUTO_WHITE_BALANCE, 1), (controls.FOCUS_AUTO, 0)]
BUSY = OSError(errno.EBUSY, 'Device or resource busy')
ABSENT = {'brightness': 5, 'contrast': 5, 'saturation': 5, 'sharpness': 5, 'gain': 0,
          'auto_white_balance': False, 'white_balance': 9, 'autoexposure': False, 'exposure': 9,
          'focus': 3}


def exposure(highest, value=1):
    return FakeDevice(controls.EXPOSURE_AUTO, high=highest, values={controls.EXPOSURE_AUTO: value})


def gain(**more):
    return FakeDevice(GAIN, low=10, high=90, **more)


# a device, settings, other controls by name; what is set, and what is said
@pytest.mark.parametrize('device, settings, intrinsic, done, problems', [
    # automatic modes like usb_cam
    (FakeDevice(), {}, {}, [], []),
    (FakeDevice(*ALL, values={controls.EXPOSURE_AUTO: 3}), {}, {}, DEFAULTS, []),
    # manual values while the automatic mode is on
    (FakeDevice(*ALL, values={controls.EXPOSURE_AUTO: 3}),
     {'autofocus': True, 'focus': 6, 'exposure': 70, 'white_balance': 3000}, {},
     [(controls.AUTO_WHITE_BALANCE, 1), (controls.FOCUS_AUTO, 1)], []),
    # automatic exposure is the mode that the camera has; one that cannot be read is not changed
    *((exposure(highest), {}, {}, [(controls.EXPOSURE_AUTO, wanted)], [])
      for highest, wanted in ((1, 0), (2, 0), (3, 3), (4, 3))),
    (exposure(3, OSError(errno.EIO, 'Input/output error')), {}, {}, [], []),
    (FakeDevice(0x00980903), ABSENT, {}, [], list(map(NOT_THERE, ABSENT))),
    (FakeDevice(0x00980903), {'autofocus': True}, {}, [], [NOT_THERE('autofocus')]),
    # values that can be set, and that cannot
    *((gain(), {'gain': value}, {}, [(GAIN, value)], []) for value in (10, 90)),
    *((gain(), {'gain': value}, {}, [],
       ['control gain: got {}, allowed is 10 to 90'.format(value)]) for value in (9, 91)),
    (gain(settable=False), {'gain': 50}, {}, [], ['control gain: it cannot be set']),
    (gain(refused=BUSY), {'gain': 50}, {}, [],
     ['control gain: the camera refuses 50: Device or resource busy']),
    # the others are set after a problem
    (FakeDevice(BRIGHTNESS, CONTRAST), {'brightness': 256, 'contrast': 90}, {},
     [(CONTRAST, 90)], ['control brightness: got 256, allowed is 0 to 255']),
    # intrinsic controls have any name of the device and are set last
    (FakeDevice(0x00980903, BRIGHTNESS), {'brightness': 9}, {'hue': 7, 'brightness': 8},
     [(BRIGHTNESS, 9), (0x00980903, 7), (BRIGHTNESS, 8)], []),
    (gain(), {}, {'gian': 1}, [], ['the camera has no control gian; did you mean gain?'])])
def test_what_is_set_and_what_is_said(device, settings, intrinsic, done, problems):
    assert apply(device, ControlSettings(**settings), intrinsic) == problems
    assert device.done == done


@pytest.mark.parametrize('name, variable', [
    (b'Brightness\0\0\0', 'brightness'), (b'White Balance, Automatic', 'white_balance_automatic'),
    (b'Exposure (Absolute)\0rest', 'exposure_absolute'), (b'LED1 Mode', 'led1_mode'),
    (b'(Zoom) 09', 'zoom_09'), (b'caf\xe9', 'caf')])
def test_names_are_those_of_v4l2_ctl(name, variable):
    assert variable_name(name) == variable


# of linux/videodev2.h: v4l2_queryctrl and v4l2_control
QUERYCTRL, CONTROL = struct.Struct('=II32siiiiI8x'), struct.Struct('=Ii')


class FakeDriver:
    """Replaces fcntl.ioctl: a driver with four controls, a heading and a disabled one."""

    def __init__(self):
        self.calls, self.value = [], 40
        self._known = [(0x00980001, 6, b'User Controls', 0, 0, 0, 0, 0),
                       (0x00980900, 1, b'Brightness', -10, 255, 5, 128, 0),
                       (0x00980901, 1, b'Contrast', 0, 255, 1, 128, 0x0001),
                       (0x00980907, 4, b'Button', 0, 0, 0, 0, 0),
                       (0x00980908, 8, b'Mask', 0, -1, 0, 0, 0),
                       (0x009a0902, 1, b'Exposure Time, Absolute', 1, 9, 1, 3, 0x0004),
                       *((0x00a00000 + kind, kind, b'Kind', 0, 3, 1, 2, 0x0002 | 0x0008)
                         for kind in (2, 3, 5, 7, 9, 0x0106))]

    def __call__(self, descriptor, request, data):
        os.fstat(descriptor)        # is it open?
        self.calls.append(request)
        if request == 0xc0445624:       # VIDIOC_QUERYCTRL of linux/videodev2.h
            asked = QUERYCTRL.unpack(data)[0]
            assert asked & 0x80000000
            for known in self._known:
                if known[0] > asked & 0x7fffffff:
                    return QUERYCTRL.pack(*known)
            raise OSError(errno.EINVAL, 'Invalid argument')
        control_id, value = CONTROL.unpack(data)
        assert control_id == 0x00980900
        if request == 0xc008561c:       # VIDIOC_S_CTRL
            self.value = value
        else:
            assert request == 0xc008561b        # VIDIOC_G_CTRL
        return CONTROL.pack(control_id, self.value)


def test_device_uses_the_ioctls_of_the_kernel(monkeypatch):
    driver = FakeDriver()
    monkeypatch.setattr('img_recog.camera.controls.fcntl.ioctl', driver)
    device = ControlDevice('/dev/null')
    assert device.controls() == [
        Control(0x00980900, 'brightness', -10, 255, 5, 128, True),
        Control(0x00980907, 'button', 0, 1, 0, 0, True),
        Control(0x00980908, 'mask', 0, 0xffffffff, 0, 0, True),
        Control(0x009a0902, 'exposure_time_absolute', 1, 9, 1, 3, False),
        # 64 bits, text and arrays need another ioctl
        *(Control(0x00a00000 + kind, 'kind', 0, 3, 1, 2, kind in (2, 3, 9))
          for kind in (2, 3, 5, 7, 9, 0x0106))]
    assert device.get(0x00980900) == 40
    device.set(0x00980900, -7)
    assert device.get(0x00980900) == -7
    device.close()
    with pytest.raises(OSError, match='Bad file descriptor'):
        device.get(0x00980900)


def test_device_that_is_not_a_camera_has_no_controls(tmp_path):
    path = tmp_path / 'device'
    path.touch()
    device = ControlDevice(str(path))
    assert device.controls() == [] and times_open(path) == 1
    device.close()
    assert times_open(path) == 0


def test_missing_device_is_an_error():
    with pytest.raises(FileNotFoundError):
        ControlDevice('/dev/no-such-video')
