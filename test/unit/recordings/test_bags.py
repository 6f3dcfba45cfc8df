"""Frames of videos and bags: images, stamps and errors for unusable files."""
import functools
import os
import shlex
import struct

import cv2
import genpy
import numpy as np
import pytest
import rosbag
import rospy
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header, String

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.errors import UserError
from img_recog.recordings import bag_file, bags, parts
from img_recog.recordings.bags import BagFrames
from img_recog.recordings.films import FilmFrames
from img_recog.recordings.frames import Remarks
from img_recog.recordings.recording_names import is_bag
from img_recog_helpers.descriptors import times_open
from img_recog_helpers.refusals import refusal
from img_recog_helpers.replaying import BLUE, RED, image
from img_recog_helpers.videos import VIDEO_RATE_HZ

RAW, COMPRESSED = '/usb_cam/image_raw', '/usb_cam/image_raw/compressed'


def raw(number, stamp, *colors, encoding='bgr8'):
    return image_msgs.to_msg(image(*colors), encoding, Header(number, rospy.Time(stamp), 'eye'))


def compressed(number, stamp, *colors):
    return compressed_image_msgs.to_msg(
        image(*colors), 'bgr8', Header(number, rospy.Time(stamp), 'eye'),
        compressed_image_msgs.CompressionSettings(format='png'))


@pytest.fixture
def make_bag(tmp_path):
    """A function that writes (topic, message, time of recording) to a bag; it returns the path."""
    def make(*entries, name='some.bag', **options):
        path = str(tmp_path / name)
        with rosbag.Bag(path, 'w', **options) as bag:
            for topic, msg, time_s in entries:
                bag.write(topic, msg, rospy.Time(time_s))
        return path
    return make


def test_video(make_video):
    path = make_video(frames=6)
    frames = FilmFrames(path)
    assert frames.expected == 6 and frames.period_ns == round(10 ** 9 / VIDEO_RATE_HZ)
    capture = cv2.VideoCapture(path, cv2.CAP_FFMPEG)
    for number, frame in enumerate(frames):
        assert frame.number == frame.header.seq == number
        assert frame.stamp_ns == frame.header.stamp.to_nsec() == number * 80000000
        assert frame.header.frame_id == 'head_camera' and frame.encoding == 'rgb8'
        assert np.array_equal(frame.image[..., ::-1], capture.read()[1])
    assert number == 5


def test_truncated_video_is_refused_at_its_end(make_video):
    path = make_video(frames=60)
    with open(path, 'r+b') as file:
        file.truncate(os.path.getsize(path) // 2)
    line = refusal(list, FilmFrames(path))
    assert path + ' breaks off after' in line and 'ffmpeg -i ' + path in line


def test_files_that_are_not_videos(tmp_path):
    for name, content in (('text.mp4', b'hello'), ('empty.mp4', b''), ('noise.mp4', bytes(999))):
        path = tmp_path / name
        path.write_bytes(content)
        line = refusal(FilmFrames, str(path))
        assert str(path) in line and line.endswith('give a video that FFmpeg plays, a folder of '
                                                   'images, or a bag with images'), line


@pytest.mark.parametrize('topic, message, compression', [
    (RAW, raw, 'none'), (COMPRESSED, compressed, 'none'), ('/eye', raw, 'bz2')])
def test_bag(make_bag, topic, message, compression):
    path = make_bag(*((topic, message(number, 50 + 0.25 * number, BLUE), 90 + number)
                      for number in range(5)), ('/other', String('x'), 91),
                    compression=compression)
    assert is_bag(path)
    frames = BagFrames(path)
    assert frames.topic == topic and frames.expected == 5
    seen = list(frames)
    assert frames.period_ns == 250000000 and frames.warnings == []
    for number, frame in enumerate(seen):
        assert frame.number == number and frame.encoding == 'bgr8'
        assert frame.stamp_ns == 50 * 10 ** 9 + number * 250000000
        assert frame.header == Header(number, rospy.Time(50 + 0.25 * number), 'eye')
        assert np.array_equal(frame.image, image(BLUE))


def test_bag_stamps_of_zero_are_replaced_by_the_time_of_recording(make_bag):
    frames = BagFrames(make_bag(*((RAW, raw(0, 0), 7 + number) for number in range(3))))
    assert [frame.stamp_ns for frame in frames] == [7 * 10 ** 9, 8 * 10 ** 9, 9 * 10 ** 9]


@pytest.mark.parametrize('stamps_ns, times_ns', [
    ((0, 1, 2), [1, 1, 2]),             # simulated time was 0 until then
    ((9 * 10 ** 9, 0, 10 ** 10), [9 * 10 ** 9, 93 * 10 ** 8, 10 ** 10])])
def test_an_image_without_a_stamp_is_not_newer_than_the_next_one(make_bag, stamps_ns, times_ns):
    entries = [(RAW, raw(number, 0), 9.3) for number in range(3)]
    for (_, msg, _), stamp_ns in zip(entries, stamps_ns):
        msg.header.stamp = rospy.Time(*divmod(stamp_ns, 10 ** 9))
    assert [frame.stamp_ns for frame in BagFrames(make_bag(*entries))] == times_ns


def test_bag_choice_of_topic(make_bag):
    path = make_bag((RAW, raw(0, 1), 1), (COMPRESSED, compressed(0, 1), 1), ('/z', raw(0, 1), 1))
    assert BagFrames(path).topic == RAW
    assert BagFrames(path, COMPRESSED).topic == COMPRESSED
    assert BagFrames(path, 'z').topic == '/z'
    line = refusal(BagFrames, path, '/y')
    assert 'no images on /y (image topics in it: {}, {}, /z)'.format(RAW, COMPRESSED) in line
    line = refusal(BagFrames, make_bag(('/b', raw(0, 1), 1), ('/a', raw(0, 1), 1)))
    assert 'images on several topics' in line and '(image topics in it: /a, /b)' in line
    assert '--topic' in line


def test_bag_without_images(make_bag):
    path = make_bag((RAW, String('no image'), 1))
    line = refusal(BagFrames, path)
    assert path in line and 'no messages of type sensor_msgs/Image' in line
    assert 'rosbag record /usb_cam/image_raw' in line
    assert 'image topics in it: none' in refusal(BagFrames, path, RAW)


def test_bag_is_closed_when_it_is_refused_and_at_its_end(make_bag):
    path = make_bag((RAW, String('no image'), 1))
    refusal(BagFrames, path)
    assert times_open(path) == 0
    path = make_bag((RAW, raw(0, 1), 1), (RAW, raw(0, 2), 2))
    frames = iter(BagFrames(path))
    next(frames)
    assert times_open(path) == 1
    list(frames)
    assert times_open(path) == 0


@pytest.mark.parametrize('gap_s', [3600, 0])
def test_stamps_may_be_an_hour_apart(make_bag, gap_s):
    frames = BagFrames(make_bag((RAW, raw(0, 5), 1), (RAW, raw(0, 5 + gap_s), 2)))
    assert len(list(frames)) == 2 and frames.period_ns == gap_s * 10 ** 9


@pytest.mark.parametrize('error', [
    rosbag.ROSBagException('bad'), genpy.MessageException('bad'), struct.error('bad'),
    OSError('bad'), EOFError('bad'), RuntimeError('bad'), ValueError('bad'), KeyError('bad'),
    AttributeError('bad'), TypeError('bad'), MemoryError('bad')],
    ids=lambda error: type(error).__name__)
def test_whatever_rosbag_raises_while_it_reads_is_damage(make_bag, monkeypatch, error):
    def fail(*_, **__):
        raise error
    path = make_bag((RAW, raw(0, 1), 1))
    frames = BagFrames(path)
    frames.bag.read_messages = fail
    for read in (frames.camera_infos, lambda: list(frames)):
        line = refusal(read)
        assert line.startswith('the bag {} is damaged: '.format(path)) and 'bad' in line
        assert line.endswith('; try rosbag reindex, or record it again')
    with monkeypatch.context() as patched:
        patched.setattr(rosbag.Bag, 'get_type_and_topic_info', fail)
        assert refusal(BagFrames, path).startswith('the bag {} is damaged: '.format(path))
    monkeypatch.setattr(bag_file, 'BagFile', fail)
    assert refusal(BagFrames, path).startswith('cannot read {} as a bag: '.format(path))


def test_truncated_bag_says_how_to_make_an_index(make_bag):
    path = make_bag(*((RAW, raw(0, number + 1), 1) for number in range(60)), name="it's a.bag")
    with open(path, 'r+b') as file:
        file.truncate(os.path.getsize(path) - 5000)
    before, _, command = refusal(BagFrames, path).partition('; create the index: ')
    assert before == 'the bag {} has no index; its recording was probably interrupted'.format(path)
    assert shlex.split(command) == ['rosbag', 'reindex', path]


def test_unusable_images_of_a_bag_are_skipped_and_reported(make_bag):
    bad = Image(header=Header(0, rospy.Time(2), 'eye'), height=9, width=9, encoding='bgr8', step=1)
    frames = BagFrames(make_bag((RAW, raw(0, 1), 1), (RAW, bad, 2), (RAW, raw(0, 3, RED), 3)))
    assert [frame.number for frame in frames] == [0, 2]
    assert len(frames.warnings) == 1
    assert frames.warnings[0].startswith(
        '1 of 3 images on {} cannot be used; the first is message 1: cannot convert an image of '
        '9x9'.format(RAW))
    line = refusal(list, BagFrames(make_bag((RAW, bad, 1))))
    assert 'no image on {}'.format(RAW) in line and 'a row takes 27 bytes' in line
    line = refusal(list, BagFrames(make_bag((COMPRESSED, CompressedImage(data=b'x'), 1))))
    assert 'no image that OpenCV can read' in line


@pytest.mark.parametrize('second, said', [
    (4.5, 'jump back by 0.5 s'), (3605.5, 'jump ahead by 3600.5 s')])
def test_bag_whose_stamps_jump(make_bag, second, said):
    path = make_bag((RAW, raw(0, 5), 1), (RAW, raw(0, second), 2))
    line = refusal(list, BagFrames(path))
    assert said + ' at message 1' in line and path in line and 'rosbag filter' in line


@pytest.mark.parametrize('compression', ['none', 'lz4'])
@pytest.mark.parametrize('chunk', [1, 30000, 768000])
def test_a_recording_begins_after_the_last_restart_of_simulated_time(
        make_bag, compression, chunk):
    runs = ([(2 + number / 10, number) for number in range(40)],
            [(number / 10, 100 + number) for number in range(9)],
            [(0.02, 4)] + [(number / 10, 200 + number) for number in range(1, 30)])
    late = raw(4, 5.9)      # sent before the restart, recorded behind it
    path = make_bag(*((topic, late if second == 0.02 else raw(number, second + 1e-9),
                       second + 0.01)
                      for topic in ('/cam/image_raw', '/other/image_raw')
                      for run in runs for second, number in run),
                    compression=compression, chunk_threshold=chunk)
    frames = BagFrames(path, '/cam/image_raw')
    found = list(frames)
    assert frames.expected == 30
    assert [(frame.number, frame.header.seq) for frame in found] == [
        (number, 200 + number) for number in range(1, 30)]
    assert frames.warnings == [
        'simulated time restarts: 49 messages of /cam/image_raw before the last restart are left '
        'out', '1 of 30 images on /cam/image_raw cannot be used; the first is message 0: its '
        'stamp is of the time before the restart']
    divided = parts.divide(path, '/cam/image_raw', 5)
    assert len(divided) > 3
    read = [parts.read(path, part) for part in divided]
    assert [(frame.number, frame.stamp_ns) for each in read for frame in each.read()] == [
        (frame.number, frame.stamp_ns) for frame in found]
    assert functools.reduce(Remarks.plus, [each.remarks for each in read]).lines(
        path) == frames.warnings


def test_a_bag_of_real_time_whose_messages_are_in_no_order_is_read_by_time(make_bag):
    day = 1700000000
    path = make_bag(*((RAW, raw(number, day + number), day + number) for number in (2, 0, 1)))
    assert [frame.header.seq for frame in BagFrames(path)] == [0, 1, 2]


@pytest.mark.parametrize('unstamped', [1, 2, 5, 60])
@pytest.mark.parametrize('stamp, lag', [(9, 0.5), (9, -0.5), (9, 1700000000)])
def test_images_without_stamps_are_not_newer_than_the_next_with_one(
        make_bag, unstamped, stamp, lag):
    entries = [(RAW, raw(number, stamp + number / 30 if number >= unstamped else 0),
                stamp + lag + number / 30) for number in range(unstamped + 3)]
    found = [frame.stamp_ns for frame in BagFrames(make_bag(*entries))]
    assert len(found) == unstamped + 3 and found == sorted(found)
    assert found[-3:] == [entry[1].header.stamp.to_nsec() for entry in entries[-3:]]


def test_images_without_stamps_do_not_wait_in_memory_for_ever(make_bag, monkeypatch):
    monkeypatch.setattr(bags, '_UNSTAMPED_BYTES', 3 * len(raw(0, 0).data))
    frames = BagFrames(make_bag(*((RAW, raw(number, 0), 1 + number) for number in range(9))))
    assert [frame.stamp_ns for frame in frames] == [
        number * 10 ** 9 for number in range(1, 10)]


@pytest.mark.parametrize('md5sum', ['0' * 32, 'f' * 32])
def test_topic_with_another_definition_of_images_is_not_used(make_bag, monkeypatch, md5sum):
    path = make_bag((RAW, raw(0, 1), 1))
    assert len(list(BagFrames(path))) == 1
    monkeypatch.setattr(Image, '_md5sum', md5sum)
    assert path + ' has no messages of type' in refusal(BagFrames, path)


@pytest.mark.parametrize('content', [b'', b'hello', b'#ROSBAG V2.0\n', b'#ROSBAG V9.9\nxxxx',
                                     b'#ROSBAG V2.0\n' + bytes(500)])
def test_files_that_are_not_bags(tmp_path, content):
    path = tmp_path / 'some.bag'
    path.write_bytes(content)
    assert is_bag(str(path))
    assert str(path) in refusal(BagFrames, str(path))


@pytest.mark.parametrize('seed', range(20))
def test_damaged_bag_is_read_or_refused_in_one_line(make_bag, seed):
    path = make_bag(*((RAW, raw(0, number + 1), 1) for number in range(40)), compression='bz2')
    random = np.random.RandomState(seed)
    with open(path, 'r+b') as file:
        data = bytearray(file.read())
        for position in random.randint(13, len(data), 20):
            data[position] = random.randint(256)
        file.seek(0)
        file.write(data)
    try:
        list(BagFrames(path))
    except UserError as error:
        assert path in str(error) and '\n' not in str(error)
