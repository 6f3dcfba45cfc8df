"""Kinds of films and pictures, compared with what the program ffmpeg makes of them.

The table test/expected/kinds.txt says how each is made, and what came out; it is read here.
"""
import functools
import os
import re
import subprocess

import av
import numpy as np
import pytest

from img_recog.camera.image_source import ImageSource
from img_recog.camera.selection import open_file
from img_recog.camera.source import SourceEnded, SourceError
from img_recog.errors import UserError
from img_recog.recordings.films import FilmFrames

PAGE = os.path.join(os.path.dirname(__file__), '../../expected/kinds.txt')
RAW = ['-f', 'rawvideo', '-pix_fmt', 'rgb24']
with open(PAGE) as file:
    ROWS = re.findall(r'(?m)^\| `\.(\w+)` \| (.*?) \| (.*?) \| (.*?) \| `(.*?)` \|$', file.read())


def ffmpeg(*words):
    return subprocess.run(['ffmpeg', '-v', 'error', *words], stdin=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, universal_newlines=True)


class Made:
    """Films and pictures of ffmpeg, and what it decodes: by one command each, if it has all."""

    def __init__(self, folder):
        self._folder = folder
        self._source = ['-f', 'lavfi', '-i', 'testsrc2=size=64x48:rate=25:duration=0.2']
        outputs = {self._path('1', extension, name): how.partition(';')[0].split()
                   for extension, name, _, _, how in ROWS}
        self._has_all = ffmpeg(*self._source, *(
            word for path, how in outputs.items() for word in [*how, path])).returncode == 0
        if self._has_all:
            inputs = [word for path in outputs for word in ('-i', path)]
            ffmpeg(*inputs, '-vsync', 'passthrough', *(
                word for number, path in enumerate(outputs) for word in [
                    '-map', '{}:v:0'.format(number), *RAW, path + '.raw']))

    def path(self, extension, name, how):
        """Return the path of a film or picture; skip the test if ffmpeg cannot write it."""
        how, *then = how.split(';')
        path = self._path('1', extension, name)
        found = None if self._has_all else ffmpeg('-y', *self._source, *how.split(), path)
        if found and re.search('Unknown encoder|suitable output format', found.stderr):
            pytest.skip('this ffmpeg cannot write it: ' + found.stderr)
        assert not found or found.returncode == 0, found.stderr
        if not then:
            return path
        before, after = then
        found = ffmpeg(*before.split(), '-i', path, *after.split(),
                       self._path('2', extension, name))
        assert found.returncode == 0, found.stderr
        return self._path('2', extension, name)

    def _path(self, step, extension, name):
        return str(self._folder / '{}{}.{}'.format(
            step, re.sub(r'\W', '', extension + name), extension))


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    return Made(tmp_path_factory.mktemp('kinds'))


def by_ffmpeg(path, shape):
    """Return the frames that ffmpeg decodes, rgb8 of this shape."""
    if not os.path.exists(path + '.raw'):
        ffmpeg('-i', path, '-map', '0:v:0', *RAW, '-vsync', 'passthrough', path + '.raw')
    return np.fromfile(path + '.raw', np.uint8).reshape(-1, *shape)


def of_camera(path):
    source, images = open_file(path, 30.0, loop=False), []
    try:
        if isinstance(source, ImageSource):
            return [source.read()]
        while True:
            images.append(source.read())
    except SourceEnded:
        return images
    finally:
        source.close()


def compared(path):
    """Return what the page states: frames here and by ffmpeg; largest and mean difference.

    Both are empty if the file is refused.
    """
    try:
        images = of_camera(path)
    except SourceError as error:
        if 'it has no decoder' in str(error) and not is_same_ffmpeg():
            pytest.skip(str(error))
        with pytest.raises(UserError, match='neither a video nor an image|of a kind that OpenCV'):
            FilmFrames(path)
        return 'refused', ''
    others = [frame.image for frame in FilmFrames(path)]
    assert np.array_equal(np.array(images), np.array(others))
    expected = by_ffmpeg(path, images[0].shape)
    difference = np.abs(np.array(images, int)[:len(expected)] - expected[:len(images)])
    return ('{}, {}'.format(len(images), len(expected)),
            '{}, {:.1f}'.format(difference.max(), difference.mean()))


@functools.lru_cache(maxsize=None)
def is_same_ffmpeg():
    """Return whether PyAV has the same FFmpeg as the program: on the reference machine it has."""
    text = subprocess.run(['ffmpeg', '-version'], stdout=subprocess.PIPE,
                          universal_newlines=True).stdout
    program = re.search(r'libswscale +(\d+)\. *(\d+)\. *(\d+)', text).groups()
    return tuple(map(int, program)) == av.library_versions['libswscale']


@pytest.mark.parametrize('extension, name, frames, difference, how', ROWS)
def test_a_kind_gives_what_the_page_says(made, extension, name, frames, difference, how):
    found_frames, found = compared(made.path(extension, name, how))
    assert found_frames == frames
    if is_same_ffmpeg():
        assert found == difference
    else:       # another version may round otherwise
        largest, stated_largest = (int(text.partition(',')[0] or 0)
                                   for text in (found, difference))
        assert largest <= stated_largest + 3


def test_the_whole_table_is_read():
    with open(PAGE) as file:
        assert len(ROWS) == file.read().count('\n| `') >= 60
