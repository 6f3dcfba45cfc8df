"""A bag file that somebody else has written: nothing in it may take more memory than it says."""
import bz2
import io
import shlex
import struct
from typing import (Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence,
                    Set, Tuple)

import genpy
import rosbag
from rosbag.bag import BagMessageWithConnectionHeader, _BagReader200

from img_recog.errors import UserError, counted, one_line
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS
from img_recog.recordings.frames import WANTED
from img_recog.recordings.recording_names import is_bag

# raised by rosbag and genpy when they read a damaged file
DAMAGE_ERRORS = (rosbag.ROSBagException, genpy.MessageException, struct.error, OSError, EOFError,
                 RuntimeError, ValueError, KeyError, AttributeError, TypeError, MemoryError)
# Of a compressed chunk, unpacked: it ends with the message by which it gets longer than the
# --chunksize of rosbag record (768 kB if it is not set). This is an image of the default
# max_image_pixels with 4 bytes a pixel, and 50 MB before it; of more pixels, if they are allowed.
_MAX_CHUNK_BYTES, _PIXEL_BYTES = 250000000, 4
_INDEX_ENTRY_BYTES = 12
_LZ4_PIECE_BYTES = 4096         # gives 1 MB at most, and a block of 4 MB
# of what time goes back by if it restarts, and up to which time it is simulated
_RESTART_S, _SIMULATED_S = 0.1, 1e9
_OP_CONNECTION = b'\x07'        # of http://wiki.ros.org/Bags/Format/2.0


class BagFile(rosbag.Bag):
    """A bag to be read by `messages`.

    A chunk is unpacked to the size that it states and no further; a bag with one that states more
    than is allowed is refused before. Messages are those of the classes that the caller knows:
    a definition in the bag, whose arrays may be of any size, is not used. If simulated time
    restarts, the messages on a topic begin after its last restart: rosbag would mix them by time.

    left_out: how many messages on a topic are before that, as soon as it was read.
    """

    def __init__(self, path: str, max_pixels: int = DEFAULT_MAX_PIXELS):
        """Open a bag; raise UserError if it has a chunk larger than an image may be."""
        self.index_entries = 0
        self.left_out: Dict[str, int] = {}
        super().__init__(path, skip_index=True)
        try:
            self._check_chunks(path, max(_MAX_CHUNK_BYTES, max_pixels * _PIXEL_BYTES))
            self._reader._read_connection_index_records()
        except BaseException:
            self.close()
            raise

    def messages(self, kinds: Mapping[str, Any], begin: Optional[genpy.Time] = None,
                 end: Optional[genpy.Time] = None) -> Iterator[BagMessageWithConnectionHeader]:
        """Yield the messages on topics in the order of recording, each with topic and timestamp.

        kinds: the class of the messages of each topic; those of other classes are left out.
        begin, end: of the times of recording. Raises one of DAMAGE_ERRORS.
        """
        self._connections_to(kinds)
        self._reader.kinds.update(((kind._type, kind._md5sum), kind) for kind in kinds.values())
        return self.read_messages(list(kinds), begin, end, _filter(kinds),
                                  return_connection_header=True)

    def connections(self) -> Set[Tuple[str, str, str]]:
        """Return topic, type and MD5 sum of all connections; a topic may have several types."""
        return {(each.topic, each.datatype, each.md5sum) for each in self._get_connections()}

    def times_ns(self, kinds: Mapping[str, Any]) -> List[int]:
        """Return when each message was recorded, by the index; kinds: as for `messages`."""
        connections = self._connections_to(kinds)
        return [entry.time.to_nsec() for entry in self._get_entries(connections)]

    def _connections_to(self, kinds: Mapping[str, Any]) -> List[Any]:
        """Return the connections of some topics; their index begins after the last restart."""
        connections = list(self._get_connections(list(kinds), _filter(kinds)))
        for topic in {each.topic for each in connections}:
            self._skip_restarts(topic, [each.id for each in connections if each.topic == topic])
        return connections

    def _skip_restarts(self, topic: str, connections: Sequence[int]) -> None:
        places = sorted((entry.chunk_pos, entry.offset, entry.time.to_sec())
                        for number in connections for entry in self._connection_indexes[number])
        starts = [index for index, (before, after) in enumerate(zip(places, places[1:]), 1)
                  if after[2] + _RESTART_S < before[2] < _SIMULATED_S]
        if starts:
            self.left_out[topic] = starts[-1]
            for number in connections:
                self._connection_indexes[number] = [
                    entry for entry in self._connection_indexes[number]
                    if (entry.chunk_pos, entry.offset) >= places[starts[-1]][:2]]

    def remarks(self, topics: Iterable[str]) -> Tuple[str, ...]:
        """Return a line on each topic of which a part is left out."""
        line = 'simulated time restarts: {} of {} before the last restart {} left out'
        return tuple(line.format(
            counted(self.left_out[topic], 'message'), topic,
            'is' if self.left_out[topic] == 1 else 'are')
            for topic in topics if topic in self.left_out)

    def _create_reader(self) -> None:
        if self.version // 100 == 2:
            self._reader = _Reader(self)
        else:
            raise rosbag.ROSBagException('its version is {}.{}, expected 2.0'.format(
                *divmod(self.version, 100)))

    def _check_chunks(self, path: str, allowed: int) -> None:
        for position, chunk in self._chunk_headers.items():
            if chunk.compression in _UNPACKERS and chunk.uncompressed_size > allowed:
                raise UserError(
                    'the bag {} has a chunk of {} bytes, in the file {}, at byte {}; allowed are '
                    '{}'.format(path, chunk.uncompressed_size, chunk.compressed_size, position,
                                allowed),
                    'if you trust it, write smaller ones: rosbag decompress '
                    + shlex.quote(path))


class _Reader(_BagReader200):
    """Reads chunks and their index; kinds: the classes of messages, by type and MD5 sum."""

    def __init__(self, bag: BagFile):
        super().__init__(bag)
        self.kinds: Dict[Tuple[str, str], Any] = {}
        self._chunk_position, self._chunk = -1, b''

    def read_connection_index_record(self) -> Any:
        found = super().read_connection_index_record()
        self.bag.index_entries += len(found[1])
        if self.bag.index_entries * _INDEX_ENTRY_BYTES > self.bag.size:     # some are read twice
            raise rosbag.ROSBagFormatException('its index is larger than the file')
        return found

    def seek_and_read_message_data_record(self, position: Tuple[int, int], raw: bool,
                                          return_connection_header: bool = False) -> Any:
        chunk, offset = self._unpacked(position[0]), position[1]
        fields = {b'op': _OP_CONNECTION}
        while fields[b'op'] == _OP_CONNECTION:      # before the first message of a connection
            header, offset = _sized(chunk, offset)
            data, offset = _sized(chunk, offset)
            fields = _fields(header)
        connection = self.bag._connections[struct.unpack('<L', fields[b'conn'])[0]]
        time = genpy.Time(*struct.unpack('<LL', fields[b'time']))
        msg = self.kinds[connection.datatype, connection.md5sum]().deserialize(data)
        return BagMessageWithConnectionHeader(connection.topic, msg, time, connection.header)

    def _unpacked(self, position: int) -> bytes:
        if position != self._chunk_position:
            self._chunk_position, self._chunk = -1, b''     # not two in memory
            header = self.bag._chunk_headers[position]
            self.bag._file.seek(header.data_pos)
            data = self.bag._encryptor.decrypt_chunk(self.bag._file.read(header.compressed_size))
            if header.compression != rosbag.Compression.NONE:
                data = _UNPACKERS[header.compression](data, header.uncompressed_size)
                if len(data) != header.uncompressed_size:
                    raise rosbag.ROSBagFormatException(
                        'the chunk at byte {} does not have the {} bytes that it states'.format(
                            position, header.uncompressed_size))
            self._chunk_position, self._chunk = position, data
        return self._chunk


def _filter(kinds: Mapping[str, Any]) -> Callable[..., bool]:
    def is_known(topic: str, type_name: str, md5sum: str, *_: Any) -> bool:
        kind = kinds.get(topic)
        return kind is not None and (type_name, md5sum) == (kind._type, kind._md5sum)
    return is_known


def _unpack_bz2(data: bytes, size: int) -> bytes:
    return bz2.BZ2Decompressor().decompress(data, size + 1)


def _unpack_lz4(data: bytes, size: int) -> bytes:
    import roslz4       # Debian has it in a package of its own
    decompressor, unpacked = roslz4.LZ4Decompressor(), io.BytesIO()
    for begin in range(0, len(data), _LZ4_PIECE_BYTES):
        unpacked.write(decompressor.decompress(data[begin:begin + _LZ4_PIECE_BYTES]))
        if unpacked.tell() > size:
            break
    return unpacked.getvalue()


_UNPACKERS: Dict[str, Callable[[bytes, int], bytes]] = {
    rosbag.Compression.BZ2: _unpack_bz2, rosbag.Compression.LZ4: _unpack_lz4}


def _sized(data: bytes, position: int) -> Tuple[bytes, int]:
    """Return what is at a position with its length before it, and the position behind it."""
    begin = position + 4
    end = begin + struct.unpack_from('<L', data, position)[0]
    if end > len(data):
        raise rosbag.ROSBagFormatException('a record is longer than its chunk')
    return data[begin:end], end


def _fields(header: bytes) -> Dict[bytes, bytes]:
    """Return the fields of the header of a record."""
    fields, position = {}, 0
    while position < len(header):
        field, position = _sized(header, position)
        name, _, value = field.partition(b'=')
        fields[name] = value
    return fields


def open_bag(path: str, max_pixels: int = DEFAULT_MAX_PIXELS, advice: str = WANTED) -> BagFile:
    """Return a bag; raise UserError if it cannot be read.

    max_pixels: of the largest image that is allowed; advice: what to give in place of a file that
    is no bag.
    """
    is_bag(path, advice)        # raises if there is no file
    try:
        return BagFile(path, max_pixels)
    except rosbag.ROSBagUnindexedException:
        raise UserError('the bag {} has no index; its recording was probably interrupted'.format(
            path), 'create the index: rosbag reindex {}'.format(shlex.quote(path)))
    except DAMAGE_ERRORS as error:
        raise UserError('cannot read {} as a bag: {}'.format(path, one_line(error)), advice)


def damaged(path: str, error: Exception) -> UserError:
    """Return the error for a bag that cannot be read to its end."""
    return UserError('the bag {} is damaged: {}'.format(path, one_line(error)),
                     'try rosbag reindex, or record it again')
