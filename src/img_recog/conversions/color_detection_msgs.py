"""Areas and centroids of colors as sensor_msgs/PointCloud, and back.

Point i is the centroid of color i in pixels (x right, y down, z 0; NaN, NaN, 0 where the color
has no pixel). Channel i has the name of color i; its values are 0 but at i, where it is the area
in pixels. So every channel has a value for each point, as the message wants, and names its color.
"""
import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, PointCloud
from std_msgs.msg import Header

from img_recog.errors import UserError

Centroid = Optional[Tuple[float, float]]
_NOWHERE = (math.nan, math.nan)


class ColorDetectionError(UserError):
    """A PointCloud holds no colors."""


class ColorDetection(NamedTuple):
    """Name, area in pixels and centroid (x, y) in pixels, or None, of each color."""

    names: List[str]
    areas_px: List[int]
    centroids: List[Centroid]


def to_msg(names: Sequence[str], areas_px: Sequence[int], centroids: Sequence[Centroid],
           header: Header) -> PointCloud:
    """Return the message for the colors of one image; names, areas and centroids in one order.

    header: the image's. The message has float32: areas above 2**24 pixels are rounded.
    """
    points = [Point32(*(centroid or _NOWHERE), 0.0) for centroid in centroids]
    channels = [ChannelFloat32(name, [0.0] * len(names)) for name in names]
    for number, area_px in enumerate(areas_px):
        channels[number].values[number] = float(area_px)
    return PointCloud(header, points, channels)


def from_msg(msg: PointCloud) -> ColorDetection:
    """Return the colors in a message.

    Raises ColorDetectionError when it has not a channel a point with a value a point.
    """
    count = len(msg.points)
    lengths = [len(channel.values) for channel in msg.channels]
    if lengths != [count] * count:
        raise ColorDetectionError(
            'PointCloud with {} points and channels of {} values, wants a channel for each point, '
            'with a value for each point'.format(count, lengths))
    return ColorDetection(
        [channel.name for channel in msg.channels],
        [int(channel.values[number]) for number, channel in enumerate(msg.channels)],
        [None if math.isnan(point.x) else (point.x, point.y) for point in msg.points])
