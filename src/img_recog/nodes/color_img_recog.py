"""The node color_extract: colours in images to commands for a robot.

Subscribes: usb_cam/image_raw (sensor_msgs/Image, any encoding that cv_bridge turns into bgr8).
Publishes, for every frame that it handles: blue_image, red_image (sensor_msgs/Image, bgr8, with
the frame's header: the frame with everything else black), then cmd_vel (geometry_msgs/Twist,
none, one or two: linear.x 10 m/s for blue, then -10 m/s for red).
Reads no parameters.
"""
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image

from img_recog.nodes import image_msgs, parameters, running, twist_msgs
from img_recog.nodes.slots import Newest
from img_recog.nodes.throttle import ThrottledWarning
from img_recog.recognition.areas import extract
from img_recog.recognition.commands import commands
from img_recog.recognition.settings import RULES

# bytes read from the socket at a time: more than any image, or rospy falls behind on large ones
_BUFFER_BYTES = 1 << 26


class ColorExtract:
    """Handles the newest frame; frames that arrive meanwhile replace each other."""

    def __init__(self):
        parameters.warn_of_unknown()
        self._frames = Newest()
        self._warn = ThrottledWarning()
        self._velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
        self._images = [rospy.Publisher(rule.color.name + '_image', Image, queue_size=1)
                        for rule in RULES]
        rospy.Subscriber('usb_cam/image_raw', Image, self._frames.put, queue_size=1,
                         buff_size=_BUFFER_BYTES, tcp_nodelay=True)

    def spin(self) -> None:
        """Handle frames until the node is shut down."""
        while not rospy.is_shutdown():
            msg = self._frames.take(timeout_s=0.1)
            if msg is not None:
                self._handle(msg)

    def _handle(self, msg: Image) -> None:
        try:
            image = image_msgs.from_msg(msg, 'bgr8')
        except image_msgs.ImageError as error:
            self._warn('frame skipped: %s', error)
            return
        areas = extract(image, [rule.color for rule in RULES])
        for publisher, area in zip(self._images, areas):
            publisher.publish(image_msgs.to_msg(area.image, 'bgr8', msg.header))
        rospy.loginfo(', '.join('{}={}'.format(area.name, area.area_px) for area in areas))
        for linear_x in commands([area.area_px for area in areas], RULES):
            self._velocity.publish(twist_msgs.to_msg(linear_x))


def main() -> int:
    """Run the node; return its exit code."""
    return running.run('color_extract', lambda: ColorExtract().spin())
