"""Reused buffers for large messages."""
import threading
from typing import Any, List, Tuple


class Packet:
    """A serialized message in a reused buffer, with a count of its owners.

    data: the buffer. Only the caller of PacketPool.take writes to it, before it calls `put`.
    note: for the caller of PacketPool.take; it is kept together with the content of the buffer.
    count: of the messages in it.
    """

    count = 1

    def __init__(self, pool: 'PacketPool', size: int):
        self.data = bytearray(size)
        self.note: Tuple[Any, Any] = (None, None)
        self._pool, self._owners = pool, 1

    def retain(self) -> None:
        """Add an owner, which must call `release` once."""
        with self._pool.lock:
            self._owners += 1

    def release(self) -> None:
        """Give up ownership; the last release makes the buffer free for reuse."""
        with self._pool.lock:
            self._owners -= 1
            if self._owners == 0:
                self._pool.free.append(self)

    def is_of(self, size: int) -> bool:
        """Return whether the buffer has `size` bytes."""
        return len(self.data) == size

    def reuse(self) -> 'Packet':
        """Return this packet, which had no owner, with one owner."""
        self._owners = 1
        return self


class PacketPool:
    """Packets without an owner, of the size that was taken last.

    Copying into new memory takes several times as long as copying into memory that was used
    before.
    """

    def __init__(self):
        self.lock = threading.Lock()
        self.free: List[Packet] = []

    def take(self, size: int) -> Packet:
        """Return a packet of `size` bytes, owned by the caller; its content is arbitrary."""
        with self.lock:
            self.free = [packet for packet in self.free if packet.is_of(size)]
            return self.free.pop().reuse() if self.free else Packet(self, size)
