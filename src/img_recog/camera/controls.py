"""V4L2 controls of a device: brightness, exposure, focus and all others that it has.

Ids, structures and names are those of linux/v4l2-controls.h and linux/videodev2.h. Controls are
set by id because the kernel has renamed some of them.
"""
import fcntl
import os
import re
import struct
from typing import Iterable, List, Mapping, NamedTuple, Optional

from img_recog.camera.usb_cam_settings import ControlSettings
from img_recog.errors import suggestion

AUTO_WHITE_BALANCE, EXPOSURE_AUTO, FOCUS_AUTO = 0x0098090c, 0x009a0901, 0x009a090c
EXPOSURE_MANUAL, EXPOSURE_APERTURE_PRIORITY = 1, 3      # enum v4l2_exposure_auto_type
_UNCHANGED = -1         # the value of a setting that sets nothing

# in the order in which they are set: the setting, its control, and the names of that which
# v4l2-ctl prints with older and newer kernels
_CONTROLS = (
    ('brightness', 0x00980900, 'brightness'), ('contrast', 0x00980901, 'contrast'),
    ('saturation', 0x00980902, 'saturation'), ('sharpness', 0x0098091b, 'sharpness'),
    ('gain', 0x00980913, 'gain'),
    ('auto_white_balance', AUTO_WHITE_BALANCE,
     'white_balance_automatic white_balance_temperature_auto'),
    ('white_balance', 0x0098091a, 'white_balance_temperature'),
    ('autoexposure', EXPOSURE_AUTO, 'auto_exposure exposure_auto'),
    ('exposure', 0x009a0902, 'exposure_absolute exposure_time_absolute'),
    ('autofocus', FOCUS_AUTO, 'focus_auto focus_automatic_continuous'),
    ('focus', 0x009a090a, 'focus_absolute'))
# the controls and the settings by these names
KNOWN_NAMES = {name: number for _, number, names in _CONTROLS for name in names.split()}
SETTINGS = {name: setting for setting, _, names in _CONTROLS for name in names.split()}

_QUERYCTRL, _CONTROL = struct.Struct('=II32siiiiI8x'), struct.Struct('=Ii')
_NEXT_CTRL = 0x80000000
_FLAG_DISABLED, _FLAG_READ_ONLY = 0x0001, 0x0004
_TYPE_BUTTON, _TYPE_CTRL_CLASS, _TYPE_BITMASK = 4, 6, 8
# integer, boolean, menu, button, bitmask, integer menu; other types need another ioctl
_SETTABLE_TYPES = (1, 2, 3, 4, 8, 9)


def _iowr(command: int, size: int) -> int:
    return 3 << 30 | size << 16 | ord('V') << 8 | command      # linux/ioctl.h


_VIDIOC_QUERYCTRL = _iowr(36, _QUERYCTRL.size)
_VIDIOC_G_CTRL = _iowr(27, _CONTROL.size)
_VIDIOC_S_CTRL = _iowr(28, _CONTROL.size)


class Control(NamedTuple):
    """One control of a device, as the driver describes it."""

    id: int
    name: str
    minimum: int
    maximum: int
    step: int
    default: int
    settable: bool


class ControlDevice:
    """The controls of a V4L2 device, by a separate file descriptor.

    All methods raise OSError as the driver reports it.
    """

    def __init__(self, path: str):
        self._descriptor = os.open(path, os.O_RDWR | os.O_NONBLOCK)

    def controls(self) -> List[Control]:
        """Return all controls of the device, in the order of their ids."""
        found: List[Control] = []
        control_id = 0
        while True:
            try:
                answer = fcntl.ioctl(self._descriptor, _VIDIOC_QUERYCTRL, _QUERYCTRL.pack(
                    control_id | _NEXT_CTRL, 0, b'', *[0] * 5))
            except OSError:         # EINVAL after the last control, ENOTTY without controls
                return found
            (control_id, control_type, name, low, high, step, default,
             flags) = _QUERYCTRL.unpack(answer)
            if control_type == _TYPE_BITMASK:
                low, high = 0, high & 0xffffffff
            elif control_type == _TYPE_BUTTON:
                low, high = 0, 1        # any value presses it
            if control_type != _TYPE_CTRL_CLASS and not flags & _FLAG_DISABLED:
                settable = (control_type in _SETTABLE_TYPES
                            and not flags & _FLAG_READ_ONLY)
                found.append(Control(control_id, variable_name(name), low, high, step, default,
                                     settable))

    def get(self, control_id: int) -> int:
        """Return the value of the control with this id."""
        request = _CONTROL.pack(control_id, 0)
        return _CONTROL.unpack(fcntl.ioctl(self._descriptor, _VIDIOC_G_CTRL, request))[1]

    def set(self, control_id: int, value: int) -> None:
        """Set the control with this id."""
        fcntl.ioctl(self._descriptor, _VIDIOC_S_CTRL,
                    struct.pack('=II', control_id, value & 0xffffffff))

    def close(self) -> None:
        """Close the file descriptor."""
        os.close(self._descriptor)


def variable_name(name: bytes) -> str:
    """Return a control's name as v4l2-ctl prints it: white_balance_auto for 'White Balance, Auto'.

    name: from the driver, terminated by a zero byte.

    >>> variable_name(b'White Balance, Automatic\\0')
    'white_balance_automatic'
    """
    text = name.split(b'\0')[0].decode('latin-1')
    return re.sub('[^0-9a-z]+', '_', text.lower()).strip('_')


def apply(device: ControlDevice, settings: ControlSettings,
          intrinsic: Mapping[str, int]) -> List[str]:
    """Set controls like usb_cam: automatic modes first, then manual values where they are off.

    intrinsic: values of any controls by name, set last.
    Returns one line for each control that could not be set. A default that the camera has no
    control for, such as autofocus off on a camera without autofocus, is not a problem.
    """
    controls = device.controls()
    by_id = {each.id: each for each in controls}
    by_name = {each.name: each for each in controls}

    def automatic(number: int, is_wanted: bool, default: bool) -> int:
        return int(is_wanted) if number in by_id or is_wanted != default else _UNCHANGED
    wanted = {
        **vars(settings),
        'auto_white_balance': automatic(AUTO_WHITE_BALANCE, settings.auto_white_balance, True),
        'white_balance': _UNCHANGED if settings.auto_white_balance else settings.white_balance,
        'autoexposure': _automatic_exposure(device, by_id.get(EXPOSURE_AUTO))
        if settings.autoexposure else EXPOSURE_MANUAL,
        'exposure': _UNCHANGED if settings.autoexposure else settings.exposure,
        'autofocus': automatic(FOCUS_AUTO, settings.autofocus, False),
        'focus': _UNCHANGED if settings.autofocus else settings.focus}
    chosen = [(name, by_id.get(number), wanted[name])
              for name, number, _ in _CONTROLS if wanted[name] != _UNCHANGED]
    chosen += [(name, by_name.get(name) or by_id.get(KNOWN_NAMES.get(name, 0)), value)
               for name, value in intrinsic.items()]
    problems = [_set(device, name, control, value) if control else _missing(name, by_name)
                for name, control, value in chosen]
    return list(filter(None, problems))


def _automatic_exposure(device: ControlDevice, control: Optional[Control]) -> int:
    """Return the mode to set; usb_cam would never turn it on again."""
    try:
        if control is not None and device.get(control.id) == EXPOSURE_MANUAL:
            # cameras have mode 3, mode 0, or both
            return EXPOSURE_APERTURE_PRIORITY if control.maximum >= 3 else 0
    except OSError:
        pass
    return _UNCHANGED


def _missing(name: str, names: Iterable[str]) -> str:
    return 'the camera has no control {}; {}'.format(
        name, suggestion(name, names) or 'v4l2-ctl --list-ctrls lists its controls')


def _set(device: ControlDevice, name: str, control: Control, value: int) -> str:
    """Set a control; return why that failed, or ''."""
    if not control.settable:
        return 'control {}: it cannot be set'.format(name)
    if not control.minimum <= value <= control.maximum:
        return 'control {}: got {}, allowed is {} to {}'.format(
            name, value, control.minimum, control.maximum)
    try:
        device.set(control.id, value)
    except OSError as error:
        return 'control {}: the camera refuses {}: {}'.format(name, value, error.strerror)
    return ''
