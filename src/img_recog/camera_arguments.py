"""What the programs agree on about images of cameras: sizes, rates, topics and frames."""
from typing import Any

from img_recog.settings import SettingError, between

CAMERA_TOPIC, CAMERA_INFO_TOPIC = 'usb_cam/image_raw', 'usb_cam/camera_info'
COMPRESSED_TOPIC = CAMERA_TOPIC + '/compressed'
# the tf frame of the images; the link that carries the camera of camera:=robot
FRAME, ROBOT_LINK = 'head_camera', 'camera_link'
SYNTHETIC, ROBOT = 'synthetic', 'robot'

# width and height: of cameras that exist, and of images that are drawn; Hz, of both
PIXELS, DRAWN_PIXELS, RATES = between(1, 16384), between(16, 4096), between(0.01, 1000)


def check_drawn(settings: Any) -> None:
    """Raise SettingError for an image_width or image_height that cannot be drawn."""
    for name in ('image_width', 'image_height'):
        if not DRAWN_PIXELS.accepts(getattr(settings, name)):
            raise SettingError(name, getattr(settings, name), 'a whole number {}, as the image is '
                               'drawn; change {}, or the camera'.format(DRAWN_PIXELS.text, name))
