"""Opens the frame source that `video_device` names."""
import dataclasses
import os
import stat
from typing import Callable, Sequence

from img_recog.camera.device_source import DeviceSource, list_devices
from img_recog.camera.image_source import (UNREADABLE, FolderSource, ImageSource, has_reader,
                                           is_jpeg_video, is_truncated, read_image)
from img_recog.camera.source import (FrameSource, RefusedSource, SourceError, check_size,
                                     convert)
from img_recog.camera.synthetic import SyntheticSource
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera_arguments import SYNTHETIC
from img_recog.formats import still_images
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS

DEFAULT_DEVICE = '/dev/video0'


def resolve_auto(settings: UsbCamSettings) -> UsbCamSettings:
    """Return the settings with `auto` replaced by the default device, or by the synthetic scene.

    A node calls this once: a camera that is unplugged later must not become the synthetic scene.
    """
    if settings.video_device != 'auto':
        return settings
    found = DEFAULT_DEVICE if os.path.exists(DEFAULT_DEVICE) else SYNTHETIC
    return dataclasses.replace(settings, video_device=found)


def open_source(settings: UsbCamSettings, folders: Sequence[str] = ('',),
                warn: Callable[[str], None] = lambda _: None) -> FrameSource:
    """Open the source that `settings.video_device` names.

    folders: where a relative path is searched for, in this order.
    warn: called with one line for each defect of a source that can still be used.
    Raises SourceError naming the path, what exists instead and what to set.
    """
    settings = resolve_auto(settings)
    name = settings.video_device
    if name == SYNTHETIC:
        check_size('cannot draw the synthetic scene', settings.image_width, settings.image_height,
                   settings.max_image_pixels)
        return SyntheticSource(settings.image_width, settings.image_height, settings.framerate)
    if '://' in name:
        from img_recog.camera.url_source import open_url    # PyAV takes 0.1 s to load
        return open_url(settings, warn)
    path = find(name, folders)
    mode = os.stat(path).st_mode
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):
        try:
            return open_file(path, settings.framerate, settings.loop, warn,
                             settings.max_image_pixels)
        except SourceError as error:        # a file does not come back, as a device does
            raise RefusedSource(error.problem, error.advice) from error
    if stat.S_ISCHR(mode):
        return DeviceSource(dataclasses.replace(settings, video_device=path))
    raise SourceError('cannot open {}: neither a device nor a file'.format(path),
                      'give one, or synthetic')


def open_file(path: str, rate_hz: float, loop: bool = True,
              warn: Callable[[str], None] = lambda _: None,
              max_pixels: int = DEFAULT_MAX_PIXELS) -> FrameSource:
    """Open an image (repeated at `rate_hz`), a folder of them, or a video (at its own rate).

    Raises SourceError when OpenCV reads the file as neither, or it has more than `max_pixels`
    pixels.
    """
    if not os.access(path, os.R_OK):
        raise SourceError('cannot read {}: permission denied'.format(path))
    if os.path.isdir(path):
        return FolderSource(path, rate_hz, loop, max_pixels, warn)
    is_video = is_jpeg_video(path)
    image = None if is_video else read_image(path, max_pixels)
    if image is not None:
        count = still_images.count(path)
        if count > 1:
            warn('{} has {} images, only the first is used; convert it to a video, or write each '
                 'to a file of a folder'.format(path, count))
        return ImageSource(path, convert(image, 'rgb8'), rate_hz)
    from img_recog.camera.video_source import VideoSource, not_playable
    if is_video:
        return VideoSource(path, loop, warn, max_pixels)
    if is_truncated(path) or has_reader(path):
        raise SourceError(UNREADABLE.format(path))
    # ffmpeg plays images too, of any size, and text files
    if has_reader(path, switched_off=True) or _is_text(path):
        raise not_playable(path)
    return VideoSource(path, loop, warn, max_pixels)


def find(name: str, folders: Sequence[str]) -> str:
    """Return the path of a device, file or folder; RefusedSource if it does not exist."""
    candidates = [os.path.join(folder, os.path.expanduser(name)) for folder in folders]
    for path in candidates:
        if os.path.exists(path):
            return os.path.abspath(path)
    missing = ('device ({})'.format(list_devices()) if candidates[0].startswith('/dev/')
               else 'file')
    raise RefusedSource(
        'cannot open {}: no such {}'.format(candidates[0], missing),
        'give a device, a video, an image, synthetic or auto: camera:=synthetic to ./run demo and '
        'roslaunch, _video_device:=synthetic to rosrun')


def _is_text(path: str) -> bool:
    # a text file would be a video of its characters
    with open(path, 'rb') as file:
        start = file.read(4096)
    return bool(start) and all(byte >= 32 or byte in b'\t\n\f\r\x1b' for byte in start)
