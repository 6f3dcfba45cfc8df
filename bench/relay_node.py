"""The least that a node does that receives images and sends two of that size, for comparison.

It recognizes nothing: it sends the commands, and each image twice, by plain sockets. So its
highest rate is what the kernel, the sender and the viewers leave to any node here.
"""
import io
import socket
import struct
import sys

import raw_topics
import rosgraph
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image

_LENGTH = struct.Struct('<I')


def send(publisher: rospy.Publisher, body) -> None:
    """Send a serialized message to all subscribers; block until it is in their socket buffers."""
    for connection in publisher.impl.connections:
        connection.socket.sendall(_LENGTH.pack(len(body)), socket.MSG_MORE)
        connection.socket.sendall(body)


def main() -> int:
    """Relay images until shut down."""
    rospy.init_node('color_extract', disable_rostime=True)
    images = [rospy.Publisher(name, Image, queue_size=1) for name in ('blue_image', 'red_image')]
    velocity = rospy.Publisher('cmd_vel', Twist, queue_size=1)
    command = io.BytesIO()
    Twist().serialize(command)
    sock = raw_topics.connect(rospy.resolve_name('usb_cam/image_raw'), rosgraph.get_master_uri())
    for message in raw_topics.messages(sock):
        for _ in range(int(sys.argv[1])):
            send(velocity, command.getvalue())
        for publisher in images:
            send(publisher, message)
    return 0


if __name__ == '__main__':
    sys.exit(main())
