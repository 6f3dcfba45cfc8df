"""Areas and centroids of colors: round trip through PointCloud, format, and refused clouds."""
import io
import math

import pytest
import rospy
from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, PointCloud
from std_msgs.msg import Header

from img_recog.conversions import color_detection_msgs
from img_recog.conversions.color_detection_msgs import ColorDetectionError

HEADER = Header(7, rospy.Time(12, 345), 'head_camera')


def sent(msg):
    """Return the message after serialization and deserialization."""
    buffer = io.BytesIO()
    msg.serialize(buffer)
    return PointCloud().deserialize(buffer.getvalue())


@pytest.mark.parametrize('names, areas_px, centroids', [
    (['blue', 'red'], [1085, 3], [(12.5, 200.25), (0.0, 271.0)]),
    (['blue', 'red'], [0, 307200], [None, (319.5, 239.5)]),
    (['green'], [0], [None]),
    (['a', 'b', 'c'], [2 ** 24, 1, 0], [(4095.5, 0.5), (0.0, 0.0), None])])
def test_round_trip(names, areas_px, centroids):
    msg = sent(color_detection_msgs.to_msg(names, areas_px, centroids, HEADER))
    assert color_detection_msgs.from_msg(msg) == (names, areas_px, centroids)
    assert msg.header == HEADER


def test_format():
    msg = sent(color_detection_msgs.to_msg(['blue', 'red'], [0, 20], [None, (1.5, 2.5)], HEADER))
    assert [channel.name for channel in msg.channels] == ['blue', 'red']
    assert [list(channel.values) for channel in msg.channels] == [[0.0, 0.0], [0.0, 20.0]]
    assert math.isnan(msg.points[0].x) and math.isnan(msg.points[0].y) and msg.points[0].z == 0
    assert msg.points[1] == Point32(1.5, 2.5, 0.0)


@pytest.mark.parametrize('points, channel, words', [
    (1, None, 'a channel for each point'), (0, [], 'a channel for each point'),
    (1, [1.0, 2.0], 'a channel for each point'), (1, [math.nan], 'finite numbers'),
    (1, [math.inf], 'finite numbers')])
def test_another_cloud_is_refused(points, channel, words):
    msg = PointCloud(points=[Point32()] * points)
    if channel is not None:
        msg.channels = [ChannelFloat32('blue', channel)]
    with pytest.raises(ColorDetectionError, match='expected ' + words):
        color_detection_msgs.from_msg(msg)
