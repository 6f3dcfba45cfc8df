"""Folders of pictures are one sequence, as for the camera node."""
import cv2
import pytest

from img_recog.camera.selection import open_file
from img_recog.camera.source import FrameSkipped, SourceEnded
from img_recog.errors import UserError
from img_recog.recordings.films import FilmFrames
from img_recog_helpers.videos import smooth_image


def save(path, number, *size):
    assert cv2.imwrite(str(path), smooth_image(number, *size))


def of_the_node(folder, rate_hz):
    """Yield the time in s and the image of each picture, as the camera node plays a folder."""
    source, number = open_file(str(folder), rate_hz, loop=False), 0
    while True:
        try:
            yield number / rate_hz, source.read().tobytes()
        except FrameSkipped:
            pass
        except SourceEnded:
            return
        number += 1


@pytest.mark.parametrize('rate_hz', [30.0, 4.0])
def test_a_folder_is_what_the_node_shows_of_it(tmp_path, rate_hz):
    for number, name in enumerate(('b.png', 'a.jpg', 'e.jp2', 'd.ras')):
        save(tmp_path / name, number)
    save(tmp_path / 'c.png', 5, 80, 48)
    (tmp_path / '0.png').write_bytes((tmp_path / 'b.png').read_bytes()[:60])
    (tmp_path / 'film.mp4').write_bytes(b'x')
    frames = FilmFrames(str(tmp_path), rate_hz=rate_hz)
    seen = list(frames)
    assert [(round(frame.stamp_ns * 1e-9, 6), frame.image.tobytes()) for frame in seen] == [
        (round(time_s, 6), image) for time_s, image in of_the_node(tmp_path, rate_hz)]
    assert [frame.number for frame in seen] == [1, 2, 4, 5] and frames.expected == 6
    assert frames.period_ns == round(1e9 / rate_hz)
    assert frames.warnings == [
        '1 of 7 entries of the folder {} left out: film.mp4'.format(tmp_path),
        '2 of 6 images cannot be used; the first is frame 0: cannot read the image '
        '{}/0.png: it is damaged, or of a kind that OpenCV does not read'.format(tmp_path)]


def test_a_picture_is_one_frame(tmp_path):
    save(tmp_path / 'a.png', 3)
    frames = FilmFrames(str(tmp_path / 'a.png'))
    frame, = frames
    assert (frame.number, frame.stamp_ns, frame.encoding) == (0, 0, 'rgb8')
    assert (frame.image[..., ::-1] == smooth_image(3)).all() and frames.expected == 1


def test_a_folder_without_pictures_is_refused_and_what_it_has_is_said(tmp_path):
    for name in ('b.mp4', 'a.mp4'):
        (tmp_path / name).write_bytes(b'x')
    with pytest.raises(UserError, match='cannot open {}: there is no image in it that can be '
                       'read; 2 of 2 entries of the folder .* left out: a.mp4, b.mp4; give a video'
                       .format(tmp_path)):
        FilmFrames(str(tmp_path))
