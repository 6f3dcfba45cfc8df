"""Recordings as users name them: films, bags and images, also by folders and patterns."""
import argparse
import glob
import os
from typing import Callable, List, Sequence

from img_recog.camera.image_source import (VIDEO_EXTENSIONS, VIDEO_OR_LIVE_EXTENSIONS, files_in,
                                           is_image)
from img_recog.camera.selection import open_file
from img_recog.camera.source import SourceError, SourceTooLarge
from img_recog.camera_arguments import CAMERA_TOPIC, COMPRESSED_TOPIC
from img_recog.errors import UserError, one_line, shortened
from img_recog.formats import still_images
from img_recog.recordings.frames import WANTED

DEFAULT_TOPICS = '/' + CAMERA_TOPIC, '/' + COMPRESSED_TOPIC
_ADVICE = 'give films, bags or images, folders with them, or patterns like "*.bag"'
_MAGIC, _BAG = b'#ROSBAG', '.bag'
_FILMS = VIDEO_EXTENSIONS + VIDEO_OR_LIVE_EXTENSIONS


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which recordings are read, and how."""
    parser.add_argument('recordings', metavar='RECORDING', nargs='+',
                        help='films, bags, images, folders with them, or patterns like "*.bag"')
    add_topic(parser)
    still_images.add_option(parser)


def add_topic(parser: argparse.ArgumentParser) -> None:
    """Add the option --topic."""
    parser.add_argument('--topic', default='', help='topic of the images in a bag (default: {}, '
                        'or the only topic with images)'.format(' or '.join(DEFAULT_TOPICS)))


def add_output(parser: argparse.ArgumentParser, names: str) -> None:
    """Add the option --output; names: of the files that are written without it."""
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write the files (default: {} in the current folder)'.format(
                            names))


def expand(names: Sequence[str], warn: Callable[[str], None] = lambda _: None) -> List[str]:
    """Return the paths of the recordings that names mean, each once, in the order of the names.

    names: of files, of folders, for all films, bags and images in them, or patterns of glob.
    warn: called with a line for each folder in which there is anything else.
    Raises UserError for a name that means none.
    """
    found: List[str] = []
    for name in names:
        name = os.path.expanduser(name)
        reason, left_out = 'no such file', ''
        if os.path.isdir(name):
            reason = 'there is no recording in it'
            paths, left_out = files_in(name, _is_recording)
        elif os.path.exists(name):
            reason = 'it is not a file'
            paths = [name] if os.path.isfile(name) else []
        else:
            paths = sorted(path for path in glob.glob(name, recursive=True)
                           if os.path.isfile(path))
        if not paths:
            raise UserError('cannot read {}: {}'.format(shortened(name), reason), _ADVICE)
        if left_out:
            warn(left_out)
        found += paths
    return list({os.path.realpath(path): path for path in reversed(found)}.values())[::-1]


def is_bag(path: str, advice: str = WANTED) -> bool:
    """Return whether a recording is a bag, by its first bytes or by its name.

    Raises UserError if there is none, or it cannot be read; advice: what to give then.
    """
    if os.path.isdir(path):
        return False
    if not os.path.exists(path) and os.path.exists(path + '.active'):
        raise UserError('{0} is not complete: there is {0}.active'.format(path),
                        'stop the demo that records it, or, if none does, rename it and run '
                        '"rosbag reindex" on it')
    if not os.path.isfile(path):
        raise UserError('cannot read {}: {}'.format(
            path, 'it is not a file' if os.path.exists(path) else 'no such file'), advice)
    try:
        with open(path, 'rb') as file:
            return file.read(len(_MAGIC)) == _MAGIC or path.endswith(_BAG)
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(path, one_line(error).lower()),
                        'see its permissions (ls -l), or give another one')


def _is_recording(path: str) -> bool:
    # by its name, so that one that is damaged is not left out but named as such
    if is_image(path) or path.lower().endswith(_FILMS) or path.endswith(_BAG):
        return True
    try:
        open_file(path, 1.0, loop=False).close()
    except SourceError as error:
        return isinstance(error, SourceTooLarge) or os.access(path, os.R_OK) and is_bag(path)
    return True
