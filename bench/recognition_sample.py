"""Send images to recognition nodes in turn; print their latency and CPU time as JSON."""
import io
import json
import struct
import sys
import threading
import time

import numpy as np
import rospy
from pictures import COMMANDS, KINDS
from ros_processes import cpu_s, wait_for
from sensor_msgs.msg import Image

RATE_HZ = 30
IN_FLIGHT = 2                   # one in processing and one waiting
_RESULT_TIMEOUT_S = 2.0
WARM_UP_S = 0.5


def packets(kind: str, width: int, height: int) -> list:
    """Return serialized images of a kind, each preceded by its length."""
    result = []
    for image in KINDS[kind](width, height):
        msg = Image(height=height, width=width, encoding='rgb8', step=3 * width,
                    data=image.tobytes())
        msg.header.frame_id = 'head_camera'
        buffer = io.BytesIO()
        msg.serialize(buffer)
        result.append(struct.pack('<I', buffer.tell()) + buffer.getvalue())
    return result


class Results:
    """Counts the frames whose results have all arrived: as many messages on each topic."""

    def __init__(self, topics: list, messages_a_frame: int):
        self._messages_a_frame = messages_a_frame
        self._condition = threading.Condition()
        self._counts = [0] * len(topics)
        self.last_s = 0.0
        self._subscribers = [
            rospy.Subscriber(topic, rospy.AnyMsg, self._came, number, buff_size=1 << 24,
                             tcp_nodelay=True) for number, topic in enumerate(topics)]

    def connected(self) -> bool:
        """Return whether each topic has a publisher."""
        return all(each.get_num_connections() for each in self._subscribers)

    def count(self) -> int:
        """Return the number of frames whose results have arrived."""
        return min(self._counts) // self._messages_a_frame

    def wait_for(self, count: int, timeout_s: float) -> bool:
        """Wait until count() is at least `count`; return False after the timeout."""
        with self._condition:
            return self._condition.wait_for(lambda: self.count() >= count, timeout_s)

    def _came(self, _, number: int) -> None:
        now_s = time.perf_counter()
        with self._condition:
            self._counts[number] += 1
            self.last_s = now_s
            self._condition.notify()


class Sender:
    """Sends prepared packets to the subscribers of a topic, in turn."""

    def __init__(self, topic: str, prepared: list):
        self._packets, self._number = prepared, 0
        self._publisher = rospy.Publisher(topic, Image, queue_size=None)

    def connections(self) -> list:
        """Return the connections to the subscribers."""
        return self._publisher.impl.connections

    def send(self) -> None:
        """Send the next packet; return when it is in the socket buffers."""
        packet = self._packets[self._number % len(self._packets)]
        self._number += 1
        for connection in self.connections():
            connection.socket.sendall(packet)


def paced(sender: Sender, results: Results, seconds: float, pids: list) -> dict:
    """Send at RATE_HZ; return CPU time per frame and latencies.

    latency_ms: the median from sending the last byte of an image to the arrival of the result;
    with_transport_ms: from sending the first byte.
    """
    latencies, lost = [], 0
    start, before = time.perf_counter(), sum(map(cpu_s, pids))
    number = round(seconds * RATE_HZ)
    for tick in range(number):
        time.sleep(max(0.0, start + tick / RATE_HZ - time.perf_counter()))
        done, begun_s = results.count(), time.perf_counter()
        sender.send()
        sent_s = time.perf_counter()
        if results.wait_for(done + 1, _RESULT_TIMEOUT_S):
            latencies.append((results.last_s - sent_s, results.last_s - begun_s))
        else:
            lost += 1
    processor = sum(map(cpu_s, pids)) - before
    latencies = 1e3 * np.array(latencies or [(np.nan, np.nan)])
    return {'cpu_ms': 1e3 * processor / number, 'lost': lost,
            'latency_99_ms': float(np.percentile(latencies[:, 0], 99)),
            'latency_ms': float(np.median(latencies[:, 0])),
            'with_transport_ms': float(np.median(latencies[:, 1]))}


def highest(sender: Sender, results: Results, seconds: float) -> dict:
    """Keep IN_FLIGHT frames in flight; return the number of frames per second."""
    first, start = results.count(), time.perf_counter()
    sent = first
    while time.perf_counter() - start < seconds:
        while sent - results.count() < IN_FLIGHT:
            sender.send()
            sent += 1
        if not results.wait_for(sent - IN_FLIGHT + 1, _RESULT_TIMEOUT_S):
            sent = results.count()      # lost: slow nodes drop frames
    rate_hz = (results.count() - first) / (time.perf_counter() - start)
    results.wait_for(sent, _RESULT_TIMEOUT_S)  # before the next node is measured
    return {'rate_hz': rate_hz}


def main() -> None:
    """Sample KIND WIDTH HEIGHT TURNS SECONDS RATES NODES.

    KIND: of the images, one of pictures.KINDS. RATES: 1 to measure the highest rates too, or 0.
    NODES: JSON, a list of name, images, results, has_image_results and pids.
    """
    kind, (width, height, turns) = sys.argv[1], map(int, sys.argv[2:5])
    seconds, rates, nodes = float(sys.argv[5]), int(sys.argv[6]), json.loads(sys.argv[7])
    rospy.init_node('recognition_sample', disable_rostime=True)
    prepared = packets(kind, width, height)
    ends = {node['name']: (Sender(node['images'], prepared), Results(
        node['results'], 1 if node['has_image_results'] else COMMANDS[kind])) for node in nodes}
    for node in nodes:
        sender, results = ends[node['name']]
        wait_for(lambda sender=sender, results=results, pids=node['pids']:
                 results.connected() and len(sender.connections()) == len(pids), node['name'])
        highest(sender, results, WARM_UP_S)
    samples = {name: [] for name in ends}
    for turn in range(turns):
        first = turn % len(nodes)       # so that it is not always the same
        for node in nodes[first:] + nodes[:first]:
            samples[node['name']].append(paced(*ends[node['name']], seconds, node['pids']))
    for turn in range(turns if rates else 0):
        for name, (sender, results) in ends.items():
            samples[name][turn].update(highest(sender, results, seconds))
    sys.stdout.write(json.dumps(samples) + '\n')


if __name__ == '__main__':
    main()
