"""Subscribe to topics, as a busy system would, and drop what comes.

The topics are the arguments; without any, all of the simulator.
"""
import sys

import rospy

TOPICS = ('/clock', '/imu', '/joint_states', '/odom', '/scan', '/tf')


def main() -> int:
    """Watch until shut down."""
    rospy.init_node('watch_all', disable_rostime=True)
    for topic in sys.argv[1:] or TOPICS:
        rospy.Subscriber(topic, rospy.AnyMsg, lambda msg: None, buff_size=1 << 24)
    rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
