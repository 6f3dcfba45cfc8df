"""What the camera can be told, with usb_cam's names and defaults."""
from dataclasses import dataclass
from typing import Any, Mapping

from img_recog.settings import (SettingError, Settings, at_least, between, not_empty, one_of,
                                setting)

# usb_cam 0.3.7's names for pixel formats, all of them, and the V4L2 FOURCC each stands for
# (linux/videodev2.h)
FOURCC = {
    'grey': 'GREY',
    'mjpeg': 'MJPG',
    'rgb24': 'RGB3',
    'uyvy': 'UYVY',
    'yuvmono10': 'Y10 ',
    'yuyv': 'YUYV',
}
GREY_FORMATS = ('grey', 'yuvmono10')


@dataclass(frozen=True)
class CameraSettings(Settings):
    """Parameters of a frame source.

    video_device: a V4L2 device, the path of a video, image or folder of images, the URL of a
        stream, video or image (rtsp://, http://), `synthetic`, or `auto` (the first device
        where there is one, else the synthetic scene).
    image_width, image_height: pixels asked of a device and drawn by the synthetic scene; other
        sources keep their own size.
    framerate: Hz asked of a device, and the most that is taken of one that gives more; kept by
        the synthetic scene and images; a video plays at its own rate, a stream as it comes.
    loop: whether videos and folders start again at their end; else the node ends there.
    create_suspended: whether the camera stays closed until ~start_capture.
    """

    video_device: str = setting('/dev/video0', not_empty())
    io_method: str = setting('mmap', one_of('mmap', 'read', 'userptr'))
    pixel_format: str = setting('mjpeg', one_of(*sorted(FOURCC)))
    image_width: int = setting(640, between(1, 16384))
    image_height: int = setting(480, between(1, 16384))
    framerate: float = setting(30.0, between(0.1, 1000))
    camera_frame_id: str = setting('head_camera', not_empty())
    camera_name: str = setting('head_camera', not_empty())
    camera_info_url: str = setting('')
    create_suspended: bool = setting(False)
    loop: bool = setting(True)


@dataclass(frozen=True)
class ControlSettings(Settings):
    """V4L2 controls of a device, in its own units; -1 leaves a control as it is.

    exposure (in 0.1 ms), white_balance (in K) and focus are in force only while the automatic
    of each is off.
    """

    brightness: int = setting(-1, at_least(-1), '-1 leaves it as it is')
    contrast: int = setting(-1, at_least(-1), '-1 leaves it as it is')
    saturation: int = setting(-1, at_least(-1), '-1 leaves it as it is')
    sharpness: int = setting(-1, at_least(-1), '-1 leaves it as it is')
    gain: int = setting(-1, at_least(-1), '-1 leaves it as it is')
    autofocus: bool = setting(False, description='whether the camera focuses by itself')
    focus: int = setting(-1, at_least(-1), 'without autofocus; -1 leaves it as it is')
    autoexposure: bool = setting(True, description='whether the camera exposes by itself')
    exposure: int = setting(100, at_least(-1), 'in 0.1 ms, without autoexposure')
    auto_white_balance: bool = setting(True, description='whether the camera finds its white')
    white_balance: int = setting(4000, at_least(-1), 'in K, without auto_white_balance')


_CONTROL_VALUES = ('a map of V4L2 control names to whole numbers, true or false, and of ignore to '
                   'a list of names')


def intrinsic_controls(given: Any) -> Mapping[str, int]:
    """Return control values by name, from the intrinsic_controls of usb_cam's later branch.

    given: a map of names as v4l2-ctl prints them to whole numbers or truth values; the names in
    its list `ignore` are left out.
    Raises SettingError when it is something else.
    """
    if not isinstance(given, Mapping):
        raise SettingError('intrinsic_controls', given, _CONTROL_VALUES)
    ignored = given.get('ignore', [])
    values = {str(name): value for name, value in given.items() if name != 'ignore'}
    if not isinstance(ignored, list) or not all(isinstance(v, int) for v in values.values()):
        raise SettingError('intrinsic_controls', given, _CONTROL_VALUES)
    return {name: int(value) for name, value in values.items() if name not in ignored}
