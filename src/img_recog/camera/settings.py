"""What the camera can be told, with usb_cam's names and defaults."""
from dataclasses import dataclass

from img_recog.settings import Settings, between, not_empty, one_of, setting

# usb_cam's names for pixel formats and the V4L2 FOURCC each stands for (linux/videodev2.h)
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

    video_device: a V4L2 device, the path of a film or still image, `synthetic`, or `auto`
        (the first device where there is one, else the synthetic scene).
    image_width, image_height: pixels asked of a device and drawn by the synthetic scene; a film
        or still image keeps its own size.
    framerate: Hz asked of a device and kept by the synthetic scene and still images; a film
        plays at its own rate.
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
