"""Reused buffers for large messages, and the threads that send them."""
import threading
from queue import Empty, SimpleQueue
from typing import Dict, List, Optional

from rospy.impl.tcpros_base import TCPROSTransport


class Packet:
    """A serialized message in a reused buffer, with a count of its owners.

    data: the buffer. Only the caller of PacketPool.take writes to it, before it calls `put`.
    """

    def __init__(self, pool: 'PacketPool', size: int):
        self.data = bytearray(size)
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
        """Return a packet of `size` bytes with arbitrary content, owned by the caller."""
        with self.lock:
            self.free = [packet for packet in self.free if packet.is_of(size)]
            return self.free.pop().reuse() if self.free else Packet(self, size)


class PacketSender:
    """Sends the newest packet to one subscriber, in a thread.

    Like with queue_size=1, a packet that is still waiting when the next one comes is dropped. A
    subscriber that does not read blocks only this thread, and keeps at most two packets. Call
    `put` and `close` from one thread.
    """

    def __init__(self, connection: TCPROSTransport):
        self._connection = connection
        # rospy's QueuedConnection returns before it has sent the data
        self._is_synchronous = isinstance(connection, TCPROSTransport)
        # at most one packet, or None for the end; faster than a Condition
        self._waiting: 'SimpleQueue[Optional[Packet]]' = SimpleQueue()
        threading.Thread(target=self._run, daemon=True).start()

    def put(self, packet: Packet) -> None:
        """Send a packet in the thread; this sender becomes an owner of it."""
        packet.retain()
        self._drop()
        self._waiting.put(packet)

    def close(self) -> None:
        """Stop after the packet that is being sent, without waiting for it."""
        self._drop()
        self._waiting.put(None)

    def _drop(self) -> None:
        try:
            packet = self._waiting.get_nowait()
        except Empty:       # the thread has taken it
            return
        if packet is not None:
            packet.release()

    def _run(self) -> None:
        packet = self._waiting.get()
        while packet is not None:
            try:
                self._connection.write_data(
                    packet.data if self._is_synchronous else bytes(packet.data))
            except Exception:       # like rospy, close the connection on any error
                self._connection.close()
            finally:
                packet.release()
            packet = self._waiting.get()


class PacketSenders:
    """A PacketSender for each connection of a topic. Use it from one thread."""

    def __init__(self):
        self._senders: Dict[TCPROSTransport, PacketSender] = {}
        self._followed: List[TCPROSTransport] = []

    def follow(self, connections: List[TCPROSTransport]) -> None:
        """Create and close senders, so that there is one for each of these connections.

        connections: rospy's list. Until the topic is closed, rospy replaces this list and never
        changes it.
        """
        if connections is self._followed:
            return
        self._followed = connections
        for gone in self._senders.keys() - set(connections):
            self._senders.pop(gone).close()
        for connection in connections:
            if connection not in self._senders:
                self._senders[connection] = PacketSender(connection)

    def put(self, packet: Packet) -> None:
        """Send a packet to all connections, in their threads."""
        for sender in self._senders.values():
            sender.put(packet)
