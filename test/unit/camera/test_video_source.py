"""Videos and images: equal to the frames that OpenCV reads."""
import cv2
import numpy as np
import pytest

from img_recog.camera.selection import open_file
from img_recog.camera.source import SourceEnded
from img_recog.camera.video_source import VideoSource
from img_recog_helpers.descriptors import times_open
from img_recog_helpers.fake_decoder import FakeDecoder
from img_recog_helpers.videos import opencv_frames


@pytest.mark.parametrize('name, options', [
    ('a.mkv', ['-c:v', 'libx264', '-pix_fmt', 'yuv444p', '-s', '97x65']),
    ('a.avi', ['-c:v', 'mpeg4']), ('a.avi', ['-c:v', 'mjpeg', '-frames:v', '1'])])
def test_video_equals_videocapture(make_film, name, options):
    path = make_film(name, *options)
    expected, source = opencv_frames(path), open_file(path, 30.0)
    assert len(expected) == (1 if '-frames:v' in options else 10)
    assert (source.height, source.width, 3) == expected[0].shape and source.rate_hz == 10
    for number, image in enumerate(expected):
        frame = source.read()
        assert np.array_equal(frame, image) and frame.flags.c_contiguous, number
        assert source.time_s == pytest.approx(number / 10, abs=1e-3)
        frame[:] = 0        # it belongs to the caller
    with pytest.raises(SourceEnded):
        source.read()
    source.close()


def test_closing_leaves_no_file_open(make_video):
    path = make_video()
    source = open_file(path, 30.0)
    source.read()
    assert times_open(path) == 1
    source.close()
    source.close()
    assert times_open(path) == 0


@pytest.mark.parametrize('name', ['still.png', 'still.bmp'])
def test_image_is_bit_identical_and_repeats(tmp_path, name):
    path, image = str(tmp_path / name), np.random.RandomState(1).randint(0, 256, (31, 47, 3))
    assert cv2.imwrite(path, image.astype(np.uint8)[..., ::-1])
    source = open_file(path, 7.5)
    assert (source.width, source.height, source.encoding) == (47, 31, 'rgb8')
    assert (source.name, source.rate_hz, source.expected_hz) == (path, 7.5, 7.5)
    assert source.description == 'image {}, 47x31, 7.5 Hz'.format(path)
    for _ in range(3):
        frame = source.read()
        assert frame.dtype == np.uint8 and np.array_equal(frame, image)
        with pytest.raises(ValueError, match='read-only'):
            frame[:] = 0
    source.close()
    source.close()


@pytest.mark.parametrize('stated, count, complete', [
    (4, 4, True), (4, 2, True), (4, 1, False), (200, 196, True), (200, 195, False),
    (100, 98, True), (100, 97, False), (0, 3, True), (3, 9, True)])
def test_a_few_frames_may_be_missing_at_the_end_of_a_video(
        clock, monkeypatch, stated, count, complete):
    monkeypatch.setattr('img_recog.camera.decoder.Decoder', lambda *_: FakeDecoder(
        clock, [True] * count + [False], 25.0, stated))
    warnings = []
    source = VideoSource('a.avi', warn=warnings.append)
    assert source.expected_frames == stated and source.rate_hz == source.expected_hz == 25
    for _ in range(count):
        source.read()
    with pytest.raises(SourceEnded):
        source.read()
    assert warnings == ([] if complete else [
        'the video a.avi breaks off after {} of {} frames: truncated or damaged'.format(
            count, stated)])
