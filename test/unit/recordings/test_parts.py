"""Parts of recordings: together they have the frames of the whole, wherever it is divided."""
import fractions

import av
import numpy as np
import pytest
import rosbag
import rospy
from std_msgs.msg import Header

from img_recog.conversions import image_msgs
from img_recog.errors import UserError
from img_recog.recordings import parts
from img_recog.recordings.bags import BagFrames
from img_recog.recordings.films import FilmFrames
from img_recog.recordings.frames import Remarks
from img_recog_helpers.videos import smooth_image

COUNT = 90


def film(path, codec, **options):
    """Write a film of COUNT frames, with a key frame in 12 if the codec has others, too."""
    with av.open(str(path), 'w') as container:
        stream = container.add_stream(codec, fractions.Fraction(25, 2))
        stream.width, stream.height, stream.gop_size = 96, 64, 12
        stream.pix_fmt = 'yuvj420p' if codec == 'mjpeg' else 'yuv420p'
        stream.options = options
        for number in range(COUNT):
            stream_frame = av.VideoFrame.from_ndarray(smooth_image(number % 10), 'bgr24')
            container.mux(stream.encode(stream_frame))
        container.mux(stream.encode(None))
    return str(path)


def bag(path, chunk_threshold=768 * 1024):
    """Write a bag of COUNT images, of which two at a time are recorded together, and one broken.

    """
    with rosbag.Bag(str(path), 'w', chunk_threshold=chunk_threshold) as written:
        for number in range(COUNT):
            msg = image_msgs.to_msg(smooth_image(number % 10), 'bgr8',
                                    Header(number, rospy.Time(5 + number / 10), 'eye'))
            if number == 40:
                msg.height += 1
            written.write('/image', msg, rospy.Time(7 + number // 2 / 5))
    return str(path)


def plain(frames):
    return [(frame.number, frame.stamp_ns, frame.header.seq, frame.header.stamp,
             frame.header.frame_id, frame.encoding, frame.image.tobytes()) for frame in frames]


def of_parts(path, frames):
    found = parts.divide(path, frames=frames)
    return [plain(parts.read(path, part).read()) for part in found], found


@pytest.mark.parametrize('name, codec, options', [
    ('closed.mp4', 'mpeg4', {'bf': '2'}), ('open.mkv', 'libx264', {'x264-params': 'open-gop=1'}),
    ('b.mp4', 'libx264', {}), ('all.avi', 'mjpeg', {}), ('stream.ts', 'mpeg2video', {'bf': '2'})])
@pytest.mark.parametrize('frames', [12, 25])
def test_the_parts_of_a_film_have_its_frames(tmp_path, name, codec, options, frames):
    path = film(tmp_path / name, codec, **options)
    whole = plain(FilmFrames(path))
    assert len(whole) == COUNT
    found, divided = of_parts(path, frames)
    assert 2 <= len(found) <= COUNT // frames
    assert sum(found, []) == whole
    assert [part.frames for part in divided] == [len(part) for part in found]


@pytest.mark.parametrize('frames', [1, 7, 45, 46])
def test_the_parts_of_a_bag_have_its_frames(tmp_path, frames):
    path = bag(tmp_path / 'some.bag', chunk_threshold=100000)
    whole = plain(BagFrames(path))
    assert len(whole) == COUNT - 1
    found, divided = of_parts(path, frames)
    assert len(found) == {1: 45, 7: 11, 45: 1, 46: 1}[frames]
    assert sum(found, []) == whole
    assert sum(part.frames for part in divided) == COUNT


def test_a_film_without_key_frames_to_divide_it_at_is_one_part(tmp_path):
    path = film(tmp_path / 'a.mp4', 'mpeg4')
    part, = parts.divide(path, frames=50)
    assert part.frames == COUNT and plain(parts.read(path, part).read()) == plain(FilmFrames(path))


def test_of_a_truncated_film_the_one_part_says_so(tmp_path):
    path = tmp_path / 'a.avi'
    content = open(film(path, 'mjpeg'), 'rb').read()
    path.write_bytes(content[:len(content) // 2])
    part, = parts.divide(str(path), frames=10)
    with pytest.raises(UserError, match='breaks off after'):
        list(parts.read(str(path), part).read())


def test_what_is_no_recording_is_refused(tmp_path):
    (tmp_path / 'a.mp4').write_bytes(bytes(999))
    with pytest.raises(UserError, match='cannot play'):
        parts.divide(str(tmp_path / 'a.mp4'))


def test_images_keep_their_limit(tmp_path):
    path = film(tmp_path / 'a.avi', 'mjpeg')
    with pytest.raises(UserError, match='pixels'):
        parts.divide(path, max_pixels=96 * 64 - 1)
    assert np.array_equal(next(parts.read(path, parts.divide(path, frames=10)[1]).read()).image,
                          list(FilmFrames(path))[10].image)


def test_damaged_frames_of_a_film_are_counted_in_the_whole_and_in_its_parts(tmp_path):
    path = film(tmp_path / 'film.avi', 'mjpeg')
    data = bytearray((tmp_path / 'film.avi').read_bytes())
    starts = [index for index in range(len(data)) if data[index:index + 3] == b'\xff\xd8\xff']
    for number in (40, 70):
        begin, end = starts[number], starts[number + 1] - 8
        data[begin:end] = bytes(end - begin)
    (tmp_path / 'film.avi').write_bytes(data)
    whole = FilmFrames(path)
    numbers = [frame.number for frame in whole]
    assert whole.warnings == ['2 of 90 images cannot be used; the first is an empty or damaged '
                              'frame of ' + path]
    read, found = of_parts(path, 20)
    assert len(found) > 2 and sum(map(len, read)) == len(numbers) == COUNT - 2
    remarks = Remarks()
    for part in found:
        frames = parts.read(path, part)
        list(frames.read())
        remarks = remarks.plus(frames.remarks)
    assert remarks == whole.remarks
    assert numbers[-1] == read[-1][-1][0] == COUNT - 1
