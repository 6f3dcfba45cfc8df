"""Read images like a viewer; print their rate, jitter and CPU time as JSON."""
import json
import os
import sys
import time

import numpy as np
import raw_topics
from ros_processes import cpu_s

SKIPPED = 30                    # at the start


def jitter_ms(times: np.ndarray) -> float:
    """Return by how much 99 % of the periods differ at most from the median."""
    periods = np.diff(times)
    return float(1e3 * np.percentile(np.abs(periods - np.median(periods)), 99))


def main() -> int:
    """Measure TOPIC, which the process PID publishes, for SECONDS."""
    topic, seconds, pid = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    begins, arrivals = [], []       # of the first and last byte of each image
    with raw_topics.connect(topic, os.environ['ROS_MASTER_URI']) as sock:
        messages = raw_topics.messages(sock, lambda: begins.append(time.perf_counter()))
        for _ in range(SKIPPED):
            next(messages)
        begins.clear()
        before, end = cpu_s(pid), time.perf_counter() + seconds
        while not arrivals or arrivals[-1] < end:
            next(messages)
            arrivals.append(time.perf_counter())
        processor = cpu_s(pid) - before
    sys.stdout.write(json.dumps({
        'rate_hz': (len(arrivals) - 1) / (arrivals[-1] - arrivals[0]),
        'cpu_ms_a_frame': 1e3 * processor / len(arrivals),
        'jitter_ms': jitter_ms(np.array(begins)),
        'arrival_jitter_ms': jitter_ms(np.array(arrivals))}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
