"""The decoder of videos and streams: OpenCV's pixels, and sizes that change on the way."""
import contextlib
import gc
import os

import cv2
import pytest

from img_recog.camera.decoder import open_decoder
from img_recog.camera.selection import open_file
from img_recog.camera.source import FrameSkipped, SourceEnded
from img_recog.recordings.films import FilmFrames

SMALL, LARGE = (96, 64), (128, 96)
H264 = ['-c:v', 'libx264', '-pix_fmt', 'yuv420p']


@pytest.fixture
def joined(make_film, tmp_path):
    """The path of two .ts files of 1 s at 10 Hz, joined; the first is small, the second large."""
    path = tmp_path / 'joined.ts'
    for size in (SMALL, LARGE):
        with open(make_film('{}.ts'.format(size[0]), *H264, '-s', '{}x{}'.format(*size)),
                  'rb') as part, open(
                str(path), 'ab') as whole:
            whole.write(part.read())
    return str(path)


@pytest.mark.parametrize('cut', [0.2, 0.5, 0.9])
def test_damaged_frames_do_not_stop_it_nor_its_release(make_film, cut):
    path = make_film('a.ts', *H264)
    with open(path, 'rb') as file:
        data = bytearray(file.read())
    for start in range(int(cut * len(data)), len(data), 188):
        data[start + 50:start + 60] = b'\xff' * 10
    with open(path, 'wb') as file:
        file.write(data)
    for count in (1, 100):
        decoder, good = open_decoder(path, 1 << 28), 0
        for _ in range(count):
            with contextlib.suppress(FrameSkipped):
                good += decoder.read() is not None
        decoder.release()
        decoder.release()
        assert good > 0


def resident_mb():
    with open('/proc/self/statm') as file:
        return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 1e6


def test_release_frees_the_memory_at_once(make_film):
    path = make_film('a.mp4', *H264, '-s', '640x480')
    gc.disable()
    try:
        for number in range(25):
            if number == 5:
                begin_mb = resident_mb()
            decoder = open_decoder(path, 1 << 28)
            assert all(decoder.read() is not None for _ in range(5))
            decoder.release()
        assert resident_mb() - begin_mb < 30
    finally:
        gc.enable()


@pytest.mark.parametrize('threads, started', [(1, 0), (2, 2)])
def test_it_has_as_many_threads_as_opencv(make_film, threads, started):
    path, before = make_film('a.mp4', *H264), cv2.getNumThreads()
    with open_decoder(path, 1 << 28) as decoder:
        decoder.read()      # the conversion has idle threads, which a later film of this size uses
    cv2.setNumThreads(threads)
    try:
        running = set(os.listdir('/proc/self/task'))
        with open_decoder(path, 1 << 28) as decoder:
            assert decoder.read() is not None
            assert len(set(os.listdir('/proc/self/task')) - running) == started
    finally:
        cv2.setNumThreads(before)


def test_a_video_whose_size_changes_goes_on_with_the_new_size(joined):
    source, images = open_file(joined, 30.0, loop=False), []
    with contextlib.suppress(SourceEnded):
        while True:
            images.append(source.read())
            assert images[-1].shape == (source.height, source.width, 3)
    source.close()
    sizes = [image.shape[1::-1] for image in images]
    assert sizes == [SMALL] * sizes.index(LARGE) + [LARGE] * 10 and sizes.index(LARGE) >= 9
    assert len({image.tobytes() for image in images}) == len(images)    # no old one is repeated


def test_replay_of_a_video_whose_size_changes_says_so_once(joined):
    frames = FilmFrames(joined)
    sizes = [frame.image.shape[1::-1] for frame in frames]
    assert set(sizes) == {SMALL, LARGE} and len(sizes) >= 19
    assert frames.warnings == [
        'the video {} changes its size from 96x64 to 128x96 after 1 s: all frames are used, each '
        'with its size'.format(joined)]
