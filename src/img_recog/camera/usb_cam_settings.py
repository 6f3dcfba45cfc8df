"""Settings of the camera, with the names and defaults of usb_cam."""
import re
from dataclasses import dataclass
from typing import Any, ClassVar, Mapping

from img_recog.camera_arguments import FRAME, PIXELS, RATES, SYNTHETIC, check_drawn
from img_recog.formats.still_images import ALLOWED_MAX_PIXELS, DEFAULT_MAX_PIXELS
from img_recog.settings import (Allowed, SettingError, Settings, at_least, not_empty, one_of,
                                setting)

# All pixel formats of usb_cam 0.3.7, and the V4L2 FOURCC of each (linux/videodev2.h)
FOURCC = {
    'bgr24': 'BGR3',
    'grey': 'GREY',
    'h264': 'H264',
    'mjpeg': 'MJPG',
    'rgb24': 'RGB3',
    'uyvy': 'UYVY',
    'yu12': 'YU12',
    'yuvmono10': 'Y10 ',
    'yuyv': 'YUYV',
}
GREY_FORMATS = ('grey', 'yuvmono10')


# camera_info_manager takes any name, but it is part of the path of the calibration file
_CAMERA_NAME = Allowed('a name without / and control characters',
                       lambda name: re.fullmatch(r'(?!\.{1,2}$|\s*$)[^/\x00-\x1f\x7f]+',
                                                 name) is not None)


@dataclass(frozen=True)
class UsbCamSettings(Settings):
    """Parameters of a frame source.

    video_device: a V4L2 device, the path of a video, image or folder of images, the URL of a
        stream or video (rtsp://, http://), `synthetic`, or `auto` (/dev/video0 if it
        exists, or else the synthetic scene).
    image_width, image_height: size requested from a device and drawn by the synthetic scene, in
        pixels; other sources keep their own size.
    framerate: rate requested from a device, in Hz, and the limit for one that gives more; the
        rate of the synthetic scene and of images. A video plays at its own rate, a stream as its
        frames arrive.
    max_image_pixels: an image or a video with more pixels is refused before it is decoded.
    loop: whether videos and folders start again at their end, or else the node ends.
    create_suspended: whether the camera stays closed until ~start_capture is called.
    """

    is_like_roscpp: ClassVar[bool] = True
    video_device: str = setting('/dev/video0', Allowed(
        'a path like /dev/video0, a URL, synthetic or auto', not_empty().accepts))
    io_method: str = setting('mmap', one_of('mmap', 'read', 'userptr'))
    pixel_format: str = setting('mjpeg', one_of(*sorted(FOURCC)))
    color_format: str = setting('yuv422p', one_of('yuv420p', 'yuv422p'))
    image_width: int = setting(640, PIXELS)
    image_height: int = setting(480, PIXELS)
    framerate: float = setting(30.0, RATES)
    camera_frame_id: str = setting(FRAME, not_empty())
    camera_name: str = setting('head_camera', _CAMERA_NAME)
    camera_info_url: str = setting('')
    create_suspended: bool = setting(False)
    max_image_pixels: int = setting(DEFAULT_MAX_PIXELS, ALLOWED_MAX_PIXELS)
    loop: bool = setting(True)

    def __post_init__(self):
        super().__post_init__()
        if self.video_device == SYNTHETIC:
            check_drawn(self)


@dataclass(frozen=True)
class ControlSettings(Settings):
    """V4L2 controls of a device, in the units of the device; -1 leaves a control unchanged.

    exposure (in 0.1 ms), white_balance (in K) and focus have an effect only while the automatic
    mode of each is off.
    """

    is_like_roscpp: ClassVar[bool] = True
    brightness: int = setting(-1, at_least(-1), '-1 leaves it unchanged')
    contrast: int = setting(-1, at_least(-1), '-1 leaves it unchanged')
    saturation: int = setting(-1, at_least(-1), '-1 leaves it unchanged')
    sharpness: int = setting(-1, at_least(-1), '-1 leaves it unchanged')
    gain: int = setting(-1, at_least(-1), '-1 leaves it unchanged')
    autofocus: bool = setting(False, description='automatic focus')
    focus: int = setting(-1, at_least(-1), 'used when autofocus is off; -1 leaves it unchanged')
    autoexposure: bool = setting(True, description='automatic exposure')
    exposure: int = setting(100, at_least(-1), 'in 0.1 ms, used when autoexposure is off')
    auto_white_balance: bool = setting(True, description='automatic white balance')
    white_balance: int = setting(4000, at_least(-1), 'in K, used when auto_white_balance is off')


_ALLOWED_CONTROLS = ('a map of V4L2 control names to whole numbers, true or false, and of ignore '
                     'to a list of names')


def intrinsic_controls(given: Any) -> Mapping[str, int]:
    """Return control values by name, from the parameter intrinsic_controls of newer usb_cam.

    given: a map of names as v4l2-ctl prints them to whole numbers or booleans; the names in its
    list `ignore` are not set.
    Raises SettingError for anything else.
    """
    if not isinstance(given, Mapping):
        raise SettingError('intrinsic_controls', given, _ALLOWED_CONTROLS)
    ignored = given.get('ignore', [])
    values = {str(name): value for name, value in given.items() if name != 'ignore'}
    if not isinstance(ignored, list) or not all(isinstance(v, int) for v in values.values()):
        raise SettingError('intrinsic_controls', given, _ALLOWED_CONTROLS)
    return {name: int(value) for name, value in values.items() if name not in ignored}
