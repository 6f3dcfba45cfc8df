"""Subscribe to images like a viewer; print their rate, jitter and CPU time as JSON."""
import json
import sys
import time

import numpy as np
import rospy
from ros_processes import cpu_s


def main() -> int:
    """Measure TOPIC, which the process PID publishes, for SECONDS."""
    topic, seconds, pid = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    rospy.init_node('image_sample', disable_rostime=True)
    arrivals = []
    rospy.Subscriber(topic, rospy.AnyMsg, lambda msg: arrivals.append(time.perf_counter()),
                     queue_size=None, buff_size=1 << 26, tcp_nodelay=True)
    while len(arrivals) < 30:           # skip the start
        time.sleep(0.1)
    before, first = cpu_s(pid), len(arrivals)
    time.sleep(seconds)
    processor, times = cpu_s(pid) - before, np.array(arrivals[first:])
    periods = np.diff(times)
    sys.stdout.write(json.dumps({
        'rate_hz': float(1 / periods.mean()),
        'cpu_ms_a_frame': 1e3 * processor / len(times),
        'jitter_ms': float(1e3 * np.percentile(np.abs(periods - np.median(periods)), 99))}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
