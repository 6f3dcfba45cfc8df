"""Read images like a viewer; print their rate, jitter and CPU time as JSON."""
import json
import os
import sys
import time

import numpy as np
import raw_topics
from ros_processes import cpu_s

SKIPPED = 30                    # at the start


def main() -> int:
    """Measure TOPIC, which the process PID publishes, for SECONDS."""
    topic, seconds, pid = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    arrivals = []
    with raw_topics.connect(topic, os.environ['ROS_MASTER_URI']) as sock:
        messages = raw_topics.messages(sock)
        for _ in range(SKIPPED):
            next(messages)
        before, end = cpu_s(pid), time.perf_counter() + seconds
        while not arrivals or arrivals[-1] < end:
            next(messages)
            arrivals.append(time.perf_counter())
        processor = cpu_s(pid) - before
    periods = np.diff(arrivals)
    sys.stdout.write(json.dumps({
        'rate_hz': float(1 / periods.mean()),
        'cpu_ms_a_frame': 1e3 * processor / len(arrivals),
        'jitter_ms': float(1e3 * np.percentile(np.abs(periods - np.median(periods)), 99))}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
