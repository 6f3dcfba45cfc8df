"""Print real time factor, frames and CPU shares of a running demo as JSON.

Arguments: SECONDS, and the ids of the processes of roscore and roslaunch.
"""
import json
import sys
import time
from statistics import median
from typing import Dict, Iterable, List, Optional

import rospy
from ros_processes import cpu_s, descendants, wait_for
from sensor_msgs.msg import CameraInfo, PointCloud
from std_msgs.msg import Float64

# words in the command line of a process, and what it is counted as
KINDS = (('respawn.py', 'others'), ('pybullet_sim.py', 'gazebo'), ('multiprocessing', 'camera'),
         ('usb_cam_node.py', 'camera'), ('color_img_recog.py', 'color_extract'))


def kind_of(pid: int) -> str:
    """Return what a process is counted as."""
    with open('/proc/{}/cmdline'.format(pid)) as file:
        command = file.read()
    return next((kind for word, kind in KINDS if word in command), 'others')


def cpu_of_all(pids: Iterable[int]) -> Dict[str, float]:
    """Return the CPU time so far of all descendants of processes, in s, by kind."""
    sums = {kind: 0.0 for _, kind in KINDS}
    for pid in descendants(*pids):
        try:
            sums[kind_of(pid)] += cpu_s(pid)
        except OSError:         # it has ended meanwhile
            continue
    return sums


def stamps_of(topic: str, kind: type) -> List[int]:
    """Subscribe to a topic; return the list that its stamps go to, in ns."""
    stamps: List[int] = []
    rospy.Subscriber(topic, kind, lambda msg: stamps.append(msg.header.stamp.to_nsec()))
    wait_for(lambda: len(stamps) > 30, topic)
    return stamps


def lost(stamps: List[int]) -> Optional[int]:
    """Return how many stamps are missing; None if their distances are not those of one period."""
    distances = [after - before for before, after in zip(stamps, stamps[1:])]
    period = median(distances)
    if any(distance % period for distance in distances):
        return None
    return int(sum(distances) / period) - len(distances)


def main() -> int:
    """Measure."""
    seconds, pids = float(sys.argv[1]), [int(word) for word in sys.argv[2:]]
    rospy.init_node('robot_camera_sample', disable_rostime=True)
    factors: List[float] = []
    rospy.Subscriber('/gazebo/real_time_factor', Float64, lambda msg: factors.append(msg.data))
    stamps = stamps_of('/usb_cam/camera_info', CameraInfo)
    first_frame, first_factor = len(stamps), len(factors)
    before, begin = cpu_of_all(pids), time.perf_counter()
    time.sleep(seconds)
    after, wall = cpu_of_all(pids), time.perf_counter() - begin
    published, measured = stamps[first_frame:], factors[first_factor:]
    # later, because it costs the recognition some time
    recognized = stamps_of('/color_detection', PointCloud)
    first_frame = len(recognized)
    time.sleep(seconds / 2)
    recognized = recognized[first_frame:]
    sys.stdout.write(json.dumps({
        'real_time_factor': median(measured), 'lowest_factor': min(measured),
        'period_ms': median(b - a for a, b in zip(published, published[1:])) / 1e6,
        'frames': len(published), 'lost': lost(published), 'not_recognized': lost(recognized),
        'cpu_share': {kind: (after[kind] - before[kind]) / wall for kind in after}}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
