"""Recordings as users name them: films, bags and images, also by folders and patterns."""
import argparse
import glob
import mimetypes
import os
from typing import Iterator, List, Sequence

import genpy
from std_msgs.msg import Header

from img_recog import still_images
from img_recog.batch import pieces
from img_recog.batch.pieces import Part
from img_recog.camera.image_source import EXTENSIONS, read_image
from img_recog.camera.settings import CameraSettings
from img_recog.errors import UserError, one_line, shortened
from img_recog.replay.chain import Frame
from img_recog.replay.inputs import DEFAULT_TOPICS
from img_recog.still_images import DEFAULT_MAX_PIXELS

_ADVICE = 'give films, bags or images, folders with them, or patterns like "*.bag"'


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which recordings are read, and how."""
    parser.add_argument('recordings', metavar='RECORDING', nargs='+',
                        help='films, bags, images, folders with them, or patterns like "*.bag"')
    parser.add_argument('--topic', default='', help='topic of the images in bags (default: {}, '
                        'or the only topic with images)'.format(' or '.join(DEFAULT_TOPICS)))
    still_images.add_option(parser)


def expand(names: Sequence[str]) -> List[str]:
    """Return the paths of the recordings that names mean, each once, in the order of the names.

    names: of files, of folders, for all films, bags and images in them, or patterns of glob.
    Raises UserError for a name that means none.
    """
    found: List[str] = []
    for name in names:
        name = os.path.expanduser(name)
        if os.path.isdir(name):
            paths = _in_folder(name)
        elif os.path.exists(name):
            paths = [name]
        else:
            paths = sorted(path for path in glob.glob(name, recursive=True)
                           if os.path.isfile(path))
        if not paths:
            raise UserError('cannot read {}: {}'.format(
                shortened(name), 'there is no recording in it' if os.path.isdir(name)
                else 'no such file'), _ADVICE)
        found += paths
    return list({os.path.realpath(path): path for path in reversed(found)}.values())[::-1]


def divide(path: str, topic: str = '', max_pixels: int = DEFAULT_MAX_PIXELS) -> List[Part]:
    """Return the parts of a recording, as pieces.divide does; an image is one part."""
    return [Part(0, 1)] if _is_image(path) else pieces.divide(path, topic, max_pixels=max_pixels)


def read(path: str, part: Part, max_pixels: int = DEFAULT_MAX_PIXELS) -> Iterator[Frame]:
    """Yield the frames of a part, as pieces.read does."""
    return _image(path, max_pixels) if _is_image(path) else pieces.read(path, part, max_pixels)


def _image(path: str, max_pixels: int) -> Iterator[Frame]:
    try:
        image = read_image(path, max_pixels)
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(path, one_line(error).lower()))
    if image is None:
        raise UserError('cannot read the image {}: it is damaged'.format(path))
    yield Frame(0, 0, Header(0, genpy.Time(0), CameraSettings().camera_frame_id), image, 'bgr8')


def _is_image(path: str) -> bool:
    return path.lower().endswith(EXTENSIONS)


def _in_folder(folder: str) -> List[str]:
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(folder, one_line(error).lower()))
    return [path for path in (os.path.join(folder, name) for name in names
                              if not name.startswith('.') and _is_recording(name))
            if os.path.isfile(path)]


def _is_recording(name: str) -> bool:
    kind = mimetypes.guess_type(name)[0] or ''
    return _is_image(name) or name.endswith('.bag') or kind.startswith('video/')
