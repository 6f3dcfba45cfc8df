"""Subscribe to all topics of the simulator and drop the messages."""
import sys

import rospy

TOPICS = ('/clock', '/imu', '/joint_states', '/odom', '/scan', '/tf')


def main() -> int:
    """Subscribe until shut down."""
    rospy.init_node('watch_all', disable_rostime=True)
    for topic in TOPICS:
        rospy.Subscriber(topic, rospy.AnyMsg, lambda msg: None, buff_size=1 << 24)
    rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
