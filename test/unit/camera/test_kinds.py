"""Kinds of films and pictures, compared with what the program ffmpeg makes of them.

The table test/expected/kinds.txt says what came out; it is read here.
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
H264 = '-c:v libx264 -pix_fmt yuv420p '
HEVC = '-c:v libx265 -x265-params log-level=none -pix_fmt yuv420p '
MPEG2 = '-c:v mpeg2video '
VP9 = '-c:v libvpx-vp9 -b:v 200k '
AV1 = '-c:v libaom-av1 -cpu-used 8 '
ONE = '-frames:v 1 '
RAW = ['-f', 'rawvideo', '-pix_fmt', 'rgb24']
# by the extension: the names of the kinds, and how ffmpeg makes them; behind a |, then from that,
# with options of the input and of the output
KINDS = {
    'mp4': {
        'h264': H264, 'h264 4:2:2': '-c:v libx264 -pix_fmt yuv422p',
        'h264 4:4:4, odd size': '-c:v libx264 -pix_fmt yuv444p -s 65x49',
        'h264 10 bit': '-c:v libx264 -pix_fmt yuv420p10le',
        'h264 gray': '-c:v libx264 -pix_fmt gray', 'h264 RGB': '-c:v libx264rgb',
        'h264 full range': '-c:v libx264 -pix_fmt yuvj420p',
        'h264 BT.709': H264 + '-colorspace bt709',
        'h264 interlaced': H264 + '-flags +ilme+ildct',
        'h264 fragmented': H264 + '-movflags frag_keyframe+empty_moov',
        'h264 with sound': H264 + '| -f lavfi -i sine=duration=0.2 | -c:v copy -c:a aac',
        'h264 variable rate': H264 + '| | -vf select=not(mod(n\\,3)) -vsync vfr ' + H264,
        'h264 with wide pixels': H264 + '-vf setsar=16/11',
        'h264 cut without encoding': H264 + '-g 50 | -ss 0.08 | -c copy', 'hevc': HEVC,
        'hevc 10 bit BT.2020': HEVC + '-pix_fmt yuv420p10le -colorspace bt2020nc',
        'av1': AV1, 'mpeg4': '-c:v mpeg4', 'mpeg2': MPEG2, 'mjpeg': '-c:v mjpeg', 'vp9': VP9},
    'mov': {
        'h264 turned by 90': H264 + '| | -c copy -metadata:s:v rotate=90',
        'h264 turned by 180': H264 + '| | -c copy -metadata:s:v rotate=180',
        'h264 turned by 270': H264 + '| | -c copy -metadata:s:v rotate=270',
        'prores': '-c:v prores_ks', 'dnxhd': '-c:v dnxhd -profile:v dnxhr_sq -s 256x128 '
        '-pix_fmt yuv422p', 'qtrle': '-c:v qtrle', 'qtrle with alpha': '-c:v qtrle -pix_fmt argb',
        'cineform': '-c:v cfhd', 'svq1': '-c:v svq1', 'v210': '-c:v v210'},
    'mkv': {
        'h264': H264, 'ffv1': '-c:v ffv1', 'ffv1 16 bit gray': '-c:v ffv1 -pix_fmt gray16le',
        'theora': '-c:v libtheora', 'vp8': '-c:v libvpx', 'huffyuv': '-c:v huffyuv',
        'dirac': '-c:v vc2 -strict -1 -pix_fmt yuv420p', 'raw': '-c:v rawvideo -pix_fmt yuv420p'},
    'webm': {'vp8': '-c:v libvpx', 'vp9': VP9, 'vp9 full range': VP9 + '-color_range pc',
             'vp9 with alpha': VP9 + '-pix_fmt yuva420p', 'av1': AV1},
    'avi': {
        'mjpeg': '-c:v mjpeg', 'mpeg4': '-c:v mpeg4', 'xvid': '-c:v libxvid', 'h264': H264,
        'msmpeg4': '-c:v msmpeg4', 'cinepak': '-c:v cinepak', 'utvideo': '-c:v utvideo',
        'dv': '-c:v dvvideo -s 720x576', 'raw YUYV': '-c:v rawvideo -pix_fmt yuyv422',
        'raw with a palette': '-c:v rawvideo -pix_fmt pal8'},
    'flv': {'flv1': '-c:v flv', 'h264': H264}, 'f4v': {'h264': H264},
    'ts': {'h264': H264, 'hevc': HEVC, 'mpeg2': MPEG2}, 'mts': {'h264': H264 + '-f mpegts'},
    'm2ts': {'h264': H264 + '-f mpegts'},
    'mpg': {'mpeg1': '-c:v mpeg1video', 'mpeg2': MPEG2}, 'vob': {'mpeg2': MPEG2},
    'mxf': {'mpeg2': MPEG2}, '3gp': {'h263': '-c:v h263 -s 176x144', 'mpeg4': '-c:v mpeg4'},
    'm4v': {'mpeg4': '-c:v mpeg4'}, 'wmv': {'wmv1': '-c:v wmv1', 'wmv2': '-c:v wmv2'},
    'asf': {'wmv2': '-c:v wmv2'}, 'ogv': {'theora': '-c:v libtheora'}, 'nut': {'h264': H264},
    'rm': {'rv20': '-c:v rv20'}, 'dv': {'dv': '-c:v dvvideo -s 720x576'},
    'y4m': {'4:2:0': '-pix_fmt yuv420p', '4:4:4': '-pix_fmt yuv444p'},
    'h264': {'no container': H264}, 'hevc': {'no container': HEVC},
    'mjpeg': {'no container': '-c:v mjpeg'}, 'm2v': {'no container': MPEG2},
    'ivf': {'vp8': '-c:v libvpx'}, 'gif': {'animated': '', 'one image': ONE},
    'jpg': {'4:2:0': ONE + '-pix_fmt yuvj420p', '4:4:4': ONE + '-pix_fmt yuvj444p',
            'gray': ONE + '-pix_fmt gray'},
    'png': {'RGB': ONE + '-pix_fmt rgb24', 'RGBA': ONE + '-pix_fmt rgba',
            'RGB 16 bit': ONE + '-pix_fmt rgb48be', 'gray': ONE + '-pix_fmt gray',
            'gray 16 bit': ONE + '-pix_fmt gray16be', 'palette': ONE + '-pix_fmt pal8',
            'black and white': ONE + '-pix_fmt monob', 'animated': '-f apng'},
    'bmp': {'RGB': ONE + '-pix_fmt bgr24', 'palette': ONE + '-pix_fmt pal8',
            'RGB 5 bit': ONE + '-pix_fmt rgb555le'},
    'tiff': {'RGB': ONE + '-pix_fmt rgb24', 'gray': ONE + '-pix_fmt gray',
             'RGB 16 bit': ONE + '-pix_fmt rgb48le', 'palette': ONE + '-pix_fmt pal8',
             'YCbCr': ONE + '-pix_fmt yuv420p'},
    'webp': {'lossy': ONE + '-c:v libwebp', 'lossless': ONE + '-c:v libwebp -lossless 1'},
    'jp2': {'RGB': ONE + '-c:v libopenjpeg -pix_fmt rgb24',
            'gray': ONE + '-c:v libopenjpeg -pix_fmt gray'},
    'ppm': {'8 bit': ONE, '16 bit': ONE + '-pix_fmt rgb48be'}, 'pgm': {'8 bit': ONE},
    'pbm': {'1 bit': ONE}, 'ras': {'RGB': ONE, 'palette': ONE + '-pix_fmt pal8'},
    'tga': {'RGB': ONE}, 'pcx': {'RGB': ONE}, 'sgi': {'RGB': ONE}, 'dpx': {'RGB': ONE},
    'xwd': {'RGB': ONE}, 'qoi': {'RGB': ONE}, 'jxl': {'RGB': ONE},
    'avif': {'av1': ONE + AV1 + '-still-picture 1'},
    'exr': {'float': ONE}, 'jls': {'RGB': ONE}, 'pam': {'RGB': ONE}, 'pfm': {'float': ONE}}


@functools.lru_cache(maxsize=None)
def stated():
    """Return the last columns of the page's table by extension and name of the kind."""
    found = {}
    with open(PAGE) as file:
        for extension, names, *values in re.findall(
                r'(?m)^\| `\.(\w+)` \| (.*?) \| (.*?) \| (.*?) \|$', file.read()):
            for name in names.split('; '):
                assert (extension, name) not in found
                found[extension, name] = values
    return found


def ffmpeg(*words):
    return subprocess.run(['ffmpeg', '-v', 'error', *words], stdin=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, universal_newlines=True)


class Made:
    """Films and pictures of ffmpeg, and what it decodes: by one command each, if it has all."""

    def __init__(self, folder):
        self._folder = folder
        self._source = ['-f', 'lavfi', '-i', 'testsrc2=size=64x48:rate=25:duration=0.2']
        outputs = {self._path('1', extension, name): how.partition('|')[0].split()
                   for extension, names in KINDS.items() for name, how in names.items()}
        self._has_all = ffmpeg(*self._source, *(
            word for path, how in outputs.items() for word in [*how, path])).returncode == 0
        if self._has_all:
            inputs = [word for path in outputs for word in ('-i', path)]
            ffmpeg(*inputs, '-vsync', 'passthrough', *(
                word for number, path in enumerate(outputs) for word in [
                    '-map', '{}:v:0'.format(number), *RAW, path + '.raw']))

    def path(self, extension, name):
        """Return the path of a film or picture; skip the test if ffmpeg cannot write it."""
        how, _, then = KINDS[extension][name].partition('|')
        path = self._path('1', extension, name)
        found = None if self._has_all else ffmpeg('-y', *self._source, *how.split(), path)
        if found and re.search('Unknown encoder|suitable output format', found.stderr):
            pytest.skip('this ffmpeg cannot write it: ' + found.stderr)
        assert not found or found.returncode == 0, found.stderr
        if not then:
            return path
        before, _, after = then.partition('|')
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


@pytest.mark.parametrize('extension, name', [
    (extension, name) for extension, names in KINDS.items() for name in names])
def test_a_kind_gives_what_the_page_says(made, extension, name):
    frames, difference = compared(made.path(extension, name))
    stated_frames, stated_difference = stated()[extension, name]
    assert frames == stated_frames
    if is_same_ffmpeg():
        assert difference == stated_difference
    else:       # another version may round otherwise
        largest, stated_largest = (int(text.partition(',')[0] or 0)
                                   for text in (difference, stated_difference))
        assert largest <= stated_largest + 3


def test_the_page_lists_these_kinds():
    kinds = [(extension, name) for extension, names in KINDS.items() for name in names]
    assert list(stated()) and sorted(stated()) == sorted(kinds) and len(kinds) >= 60
