"""From the text of `video_device` to the frame source that it names."""
import dataclasses
import os
import stat
from typing import Sequence

from img_recog.camera.opencv_source import DeviceSource, list_devices, open_file
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import FrameSource, SourceError
from img_recog.camera.synthetic import SyntheticSource

DEFAULT_DEVICE = '/dev/video0'


def open_source(settings: CameraSettings, folders: Sequence[str] = ('',)) -> FrameSource:
    """Open what `settings.video_device` names.

    folders: where a relative path is looked for, in this order.
    Raises SourceError naming the path, what there is instead and what to set.
    """
    name = settings.video_device
    if name == 'auto':
        name = DEFAULT_DEVICE if os.path.exists(DEFAULT_DEVICE) else 'synthetic'
    if name == 'synthetic':
        return SyntheticSource(settings.image_width, settings.image_height, settings.framerate)
    path = _find(name, folders)
    if stat.S_ISREG(os.stat(path).st_mode):
        return open_file(path, settings.framerate)
    if stat.S_ISCHR(os.stat(path).st_mode):
        return DeviceSource(dataclasses.replace(settings, video_device=path))
    raise SourceError('cannot open {}: neither a device nor a file; set video_device to one, '
                      'or to synthetic'.format(path))


def _find(name: str, folders: Sequence[str]) -> str:
    candidates = [os.path.join(folder, os.path.expanduser(name)) for folder in folders]
    for path in candidates:
        if os.path.exists(path):
            return os.path.abspath(path)
    raise SourceError('cannot open {}: no such file or device (have {}); set video_device to a '
                      'device, a film, a still image, synthetic or auto'
                      .format(candidates[0], list_devices()))
