"""Subscribe to images and drop what comes, at so little cost that it is the senders one measures.

The topics are the arguments.
"""
import sys

import rospy

from img_recog.ros.transport.image_subscriber import ImageSubscriber


def watch(topic: str) -> None:
    """Drop the images of a topic."""
    subscriber = ImageSubscriber(topic, lambda msg: subscriber.release(msg))


def main() -> int:
    """Watch until shut down."""
    rospy.init_node('watch_images', disable_rostime=True)
    for topic in sys.argv[1:]:
        watch(topic)
    rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
