"""Subscribe to the given topics and drop the images, with little CPU time."""
import sys

import rospy

from img_recog.ros.transport.image_subscriber import ImageSubscriber

if __name__ == '__main__':
    rospy.init_node('watch_images', disable_rostime=True)
    for name in sys.argv[1:]:
        ImageSubscriber(name, lambda msg: None)
    rospy.spin()
