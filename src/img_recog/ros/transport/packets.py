"""Reused buffers for large messages, and the threads that send them."""
import threading
from queue import Empty, SimpleQueue
from typing import Dict, List, Optional

from rospy.impl.tcpros_base import TCPROSTransport


class Packet:
    """A serialized message in a reused buffer, with a count of those who still need it.

    data: the buffer. It belongs to whoever took the packet until it is given to a sender.
    """

    def __init__(self, pool: 'PacketPool', size: int):
        self.data = bytearray(size)
        self._pool, self._owners = pool, 1

    def retain(self) -> None:
        """Add an owner, who will call `release` once."""
        with self._pool.lock:
            self._owners += 1

    def release(self) -> None:
        """Give up ownership; the last owner's release makes the buffer free for reuse."""
        with self._pool.lock:
            self._owners -= 1
            if self._owners == 0:
                self._pool.free.append(self)

    def is_of(self, size: int) -> bool:
        """Return whether the buffer has `size` bytes."""
        return len(self.data) == size

    def reuse(self) -> 'Packet':
        """Return this packet, which nobody owned, with one owner."""
        self._owners = 1
        return self


class PacketPool:
    """Packets that nobody owns any more, of the size that was taken last.

    A copy into memory that was not used before takes several times as long as one into the same
    memory again.
    """

    def __init__(self):
        self.lock = threading.Lock()
        self.free: List[Packet] = []

    def take(self, size: int) -> Packet:
        """Return a packet of `size` bytes with any content, owned by the caller."""
        with self.lock:
            self.free = [packet for packet in self.free if packet.is_of(size)]
            return self.free.pop().reuse() if self.free else Packet(self, size)


class PacketSender:
    """Sends the newest packet to one subscriber, in a thread.

    A packet that was not begun when the next one comes is dropped, as with a queue of one. A
    subscriber that does not read holds up this thread only, and keeps two packets at most. `put`
    and `close` are for one thread.
    """

    def __init__(self, connection: TCPROSTransport):
        self._connection = connection
        # rospy's QueuedConnection returns before it has sent what it was given
        self._is_synchronous = isinstance(connection, TCPROSTransport)
        # at most one packet, or None for the end; cheaper than a Condition
        self._waiting: 'SimpleQueue[Optional[Packet]]' = SimpleQueue()
        threading.Thread(target=self._run, daemon=True).start()

    def put(self, packet: Packet) -> None:
        """Have a packet sent, which is this sender's too from now on."""
        packet.retain()
        self._drop()
        self._waiting.put(packet)

    def close(self) -> None:
        """Send nothing more than what is being sent; do not wait for that."""
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
            except Exception:       # like rospy, take any error for the end of the connection
                self._connection.close()
            finally:
                packet.release()
            packet = self._waiting.get()


class PacketSenders:
    """A PacketSender for each connection of a topic; to be used from one thread."""

    def __init__(self):
        self._senders: Dict[TCPROSTransport, PacketSender] = {}
        self._followed: List[TCPROSTransport] = []

    def follow(self, connections: List[TCPROSTransport]) -> None:
        """Have senders for these connections and no others.

        connections: rospy's list, which it replaces and does not change, until the topic is
        closed.
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
        """Have a packet sent to all connections."""
        for sender in self._senders.values():
            sender.put(packet)
