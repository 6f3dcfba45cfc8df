"""Send one prepared image again and again, with nothing else to do: the floor of a camera."""
import sys
import time

import rospy
from recognition_sample import Sender, packets


def main() -> int:
    """Send images of WIDTH HEIGHT to the topic image_raw at RATE_HZ until shut down."""
    width, height, rate_hz = (int(argument) for argument in sys.argv[1:4])
    rospy.init_node('bare_camera', disable_rostime=True)
    sender = Sender('image_raw', packets('film', width, height)[:1])
    deadline_s = time.perf_counter()
    while not rospy.is_shutdown():
        deadline_s = max(deadline_s + 1 / rate_hz, time.perf_counter())
        time.sleep(max(0.0, deadline_s - time.perf_counter()))
        sender.send()
    return 0


if __name__ == '__main__':
    sys.exit(main())
