"""Subscribe to the given topics and drop the images, with little CPU time."""
import sys

import rospy

from img_recog.ros.transport.image_subscriber import ImageSubscriber


def watch(topic: str) -> None:
    """Subscribe to a topic and drop its images."""
    ImageSubscriber(topic, lambda msg: None)


def main() -> int:
    """Subscribe until shut down."""
    rospy.init_node('watch_images', disable_rostime=True)
    for topic in sys.argv[1:]:
        watch(topic)
    rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
