"""Bags that claim more than they hold are refused before memory is taken; large ones are read."""
import bz2
import io
import struct

import genpy
import pytest
import rosbag
import roslz4
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.errors import UserError
from img_recog.recordings.bag_file import BagFile, open_bag
from img_recog.recordings.bags import BagFrames
from img_recog_helpers import refusals
from img_recog_helpers.descriptors import times_open

RAW = '/usb_cam/image_raw'
UNPACKED = {'bz2': bz2.decompress, 'lz4': roslz4.decompress}
PACKED = {'bz2': bz2.compress, 'lz4': roslz4.compress, 'none': bytes}


def message(number, side=40):
    return Image(Header(number, genpy.Time(5 + number), 'eye'), side, side, 'bgr8', 0, 3 * side,
                 bytes([number % 256]) * (3 * side * side))


def honest(path, count=4, compression='none', side=40, **options):
    with rosbag.Bag(str(path), 'w', compression=compression, **options) as bag:
        for number in range(count):
            bag.write(RAW, message(number, side), genpy.Time(5 + number))
    return str(path)


def with_chunk(path, content, compression, size=None):
    """Replace what is in the only chunk of a bag, and the size that its header states."""
    with rosbag.Bag(path) as bag:
        (position, chunk), = bag._chunk_headers.items()
        index = bag._index_data_pos
    with open(path, 'rb') as file:
        data = file.read()
    packed = PACKED[compression](content)
    header = b''.join(struct.pack('<L', len(field)) + field for field in (
        b'op=\x05', b'compression=' + compression.encode(),
        b'size=' + struct.pack('<L', len(content) if size is None else size)))
    after = data[chunk.data_pos + chunk.compressed_size:]
    begin = data[:position] + struct.pack('<L', len(header)) + header
    moved = len(begin) + 4 + len(packed) - (chunk.data_pos + chunk.compressed_size)
    changed = begin + struct.pack('<L', len(packed)) + packed + after
    changed = changed.replace(b'index_pos=' + struct.pack('<Q', index),
                              b'index_pos=' + struct.pack('<Q', index + moved), 1)
    with open(path, 'wb') as file:
        file.write(changed)
    return path


def content_of(path):
    """Return what is in the only chunk of a bag."""
    with rosbag.Bag(path) as bag:
        chunk, = bag._chunk_headers.values()
        bag._file.seek(chunk.data_pos)
        return bytes(bag._file.read(chunk.compressed_size))


def refusal(path):
    line = refusals.refusal(lambda: list(BagFrames(path)))
    assert path in line
    return line


@pytest.fixture
def no_unpacking(monkeypatch):
    def fail(*_):
        pytest.fail('it was unpacked')
    for name in ('BZ2Decompressor', 'decompress'):
        monkeypatch.setattr(bz2, name, fail)
    for name in ('LZ4Decompressor', 'decompress'):
        monkeypatch.setattr(roslz4, name, fail)


@pytest.mark.parametrize('compression', ['bz2', 'lz4'])
@pytest.mark.parametrize('side, allowed', [(0, 250000000), (9000, 324000000)])
def test_a_chunk_that_states_too_much_is_refused_before_it_is_unpacked(
        tmp_path, no_unpacking, compression, side, allowed):
    path = with_chunk(honest(tmp_path / 'a.bag'), bytes(9), compression, allowed + 1)
    line = refusals.refusal(open_bag, path, side * side or 1)
    assert line.startswith(
        'the bag {} has a chunk of {} bytes, in the file '.format(path, allowed + 1))
    assert 'allowed are {}; if you trust it, write smaller ones: rosbag decompress {}'.format(
        allowed, path) in line
    open_bag(with_chunk(honest(tmp_path / 'b.bag'), bytes(9), compression, allowed),
             side * side or 1).close()


@pytest.mark.parametrize('compression', ['bz2', 'lz4'])
def test_a_chunk_is_unpacked_to_the_size_that_it_states_and_no_further(
        tmp_path, monkeypatch, compression):
    path = with_chunk(honest(tmp_path / 'a.bag'), bytes(60000000), compression, 20000)
    given = []

    class Counting(io.BytesIO):
        def write(self, data):
            given.append(len(data))
            return super().write(data)
    monkeypatch.setattr('io.BytesIO', Counting)
    bz2_decompressor = bz2.BZ2Decompressor

    class Bz2:
        def decompress(self, data, most=-1):
            found = bz2_decompressor().decompress(data, most)
            given.append(len(found))
            return found
    monkeypatch.setattr(bz2, 'BZ2Decompressor', Bz2)
    assert 'the chunk at byte 4117 does not have the 20000 bytes that it states' in refusal(path)
    assert 20000 < sum(given) <= 20001 + (1 << 22)


@pytest.mark.parametrize('compression', ['none', 'bz2', 'lz4'])
@pytest.mark.parametrize('options', [{}, {'chunk_threshold': 50000000}, {'chunk_threshold': 0}])
def test_honest_bags_of_any_size_of_chunks_are_read(tmp_path, compression, options):
    path = honest(tmp_path / 'a.bag', 12, compression, 500, **options)
    assert [frame.header.seq for frame in BagFrames(path)] == list(range(12))


def test_an_image_as_large_as_is_allowed_is_read_from_a_compressed_chunk(tmp_path):
    path = honest(tmp_path / 'a.bag', 1, 'lz4', 7000)       # 147 MB
    assert [frame.image.shape for frame in BagFrames(path)] == [(7000, 7000, 3)]


def test_what_the_node_refuses_by_size_the_reader_of_bags_skips(tmp_path):
    path = honest(tmp_path / 'a.bag', 2)
    with pytest.raises(UserError, match='40x40 are 1600 pixels, more than max_image_pixels'):
        list(BagFrames(path, max_pixels=1599))
    assert len(list(BagFrames(path, max_pixels=1600))) == 2


def changed(path, old, new, count=1):
    with open(path, 'rb') as file:
        data = file.read()
    assert data.count(old) >= 1 and len(old) == len(new)
    with open(path, 'wb') as file:
        file.write(data.replace(old, new, count))
    return path


@pytest.mark.parametrize('count', [5, 1 << 31, (1 << 32) - 1])
def test_an_index_that_states_more_messages_than_there_are_is_refused(tmp_path, count):
    path = changed(honest(tmp_path / 'a.bag'), b'count=\x04\0\0\0',
                   b'count=' + struct.pack('<L', count))
    refusal(path)


def test_an_index_that_is_read_again_and_again_is_refused(tmp_path):
    path = honest(tmp_path / 'a.bag', 200, side=1)
    with rosbag.Bag(path) as bag:
        begin = bag._index_data_pos
    with open(path, 'rb') as file:
        data = file.read()
    chunk_info = data[len(data) - _bytes_of_last_record(data, begin):]
    with open(path, 'wb') as file:
        file.write(data.replace(b'chunk_count=\x01', b'chunk_count=\x64') + 99 * chunk_info)
    with pytest.raises(UserError, match='its index is larger than the file'):
        open_bag(path)


def _bytes_of_last_record(data, begin):
    position = begin
    while True:
        header, = struct.unpack_from('<L', data, position)
        body, = struct.unpack_from('<L', data, position + 4 + header)
        size = 8 + header + body
        if position + size == len(data):
            return size
        position += size


@pytest.mark.parametrize('compression', ['none', 'bz2', 'lz4'])
@pytest.mark.parametrize('size', [1 << 31, (1 << 32) - 1, 4900])
def test_a_message_that_states_more_than_is_in_its_chunk_is_damage(tmp_path, compression, size):
    path = honest(tmp_path / 'a.bag', 1)
    content = content_of(path)
    data = io.BytesIO()
    message(0).serialize(data)
    stated = struct.pack('<L', len(data.getvalue()))
    content = content.replace(stated + data.getvalue(),
                              struct.pack('<L', size) + data.getvalue())
    assert content != content_of(path)
    with_chunk(path, content, compression)
    assert refusal(path).startswith('the bag {} is damaged: '.format(path))


@pytest.mark.parametrize('height, words', [
    (1 << 31, 'more than max_image_pixels'), (41, 'the data is too short')])
def test_pixels_that_an_image_states_and_does_not_have_are_not_made(tmp_path, height, words):
    path = honest(tmp_path / 'a.bag', 1)
    content = content_of(path).replace(struct.pack('<LL', 40, 40), struct.pack('<LL', height, 40))
    assert content != content_of(path)
    assert words in refusal(with_chunk(path, content, 'bz2'))


@pytest.mark.parametrize('definition', [
    'Header header\nfloat64[4000000000] data', 'uint8[4000000000] data'])
def test_the_definition_of_a_message_in_the_bag_is_not_used(tmp_path, monkeypatch, definition):
    monkeypatch.setattr(Image, '_full_text', definition)
    path = honest(tmp_path / 'a.bag')
    monkeypatch.undo()
    monkeypatch.setattr(rosbag.bag, '_get_message_type', lambda _: pytest.fail('it was used'))
    assert definition.encode() in open(path, 'rb').read()
    assert len(list(BagFrames(path))) == 4


def test_fields_of_a_header_without_end_are_read_once(tmp_path):
    # rosbag copies what is left of a header for each of its fields
    path = honest(tmp_path / 'a.bag', 1)
    header = 4000000 * (struct.pack('<L', 3) + b'a=b')
    path = with_chunk(path, struct.pack('<L', len(header)) + header + bytes(4), 'lz4')
    assert 'is damaged' in refusal(path)


def test_other_versions_of_bags_are_refused(tmp_path):
    (tmp_path / 'a.bag').write_bytes(b'#ROSBAG V1.2\n' + bytes(99))
    with pytest.raises(UserError, match='its version is 1.2, expected 2.0'):
        open_bag(str(tmp_path / 'a.bag'))


def test_a_refused_bag_is_closed(tmp_path):
    path = with_chunk(honest(tmp_path / 'a.bag'), bytes(9), 'bz2', 1 << 31)
    with pytest.raises(UserError):
        BagFile(path)
    assert times_open(path) == 0
