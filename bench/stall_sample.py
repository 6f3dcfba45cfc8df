"""Print the longest pauses of /clock when the first subscribers of images come, as JSON."""
import json
import sys
import time
from typing import List

import rospy
from ros_processes import wait_for
from rosgraph_msgs.msg import Clock

# nothing, and then one subscriber more: a camera on the robot, and the view
TOPICS = ('', '/usb_cam/camera_info', '/gazebo/view/image_raw')


def main() -> int:
    """Measure SECONDS before the first subscriber, and after the first message of each."""
    seconds = float(sys.argv[1])
    rospy.init_node('stall_sample', disable_rostime=True)
    clocks: List[float] = []
    rospy.Subscriber('/clock', Clock, lambda msg: clocks.append(time.perf_counter()),
                     tcp_nodelay=True)
    wait_for(lambda: len(clocks) > 100, '/clock')
    found = []
    for topic in TOPICS:
        arrivals: List[float] = []
        first, begin = len(clocks), time.perf_counter()
        if topic:
            rospy.Subscriber(topic, rospy.AnyMsg,
                             lambda msg, into=arrivals: into.append(time.perf_counter()),
                             buff_size=1 << 24, tcp_nodelay=True)
            wait_for(lambda: arrivals, topic)
        time.sleep(seconds)
        times = clocks[first:]
        found.append({'topic': topic, 'pause_ms': 1e3 * max(
            after - before for before, after in zip(times, times[1:])),
            'first_ms': 1e3 * (arrivals[0] - begin) if arrivals else 0.0})
    sys.stdout.write(json.dumps(found) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
