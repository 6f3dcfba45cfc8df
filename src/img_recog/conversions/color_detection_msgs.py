"""Converts areas and centroids of colors to sensor_msgs/PointCloud and back.

Point i is the centroid of color i in pixels (x right, y down, z 0); it is (NaN, NaN, 0) if the
color has no pixels. Channel i has the name of color i. Its values are 0, except for value i: the
area in pixels. So each channel has one value for each point, as the message requires.
"""
import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, PointCloud
from std_msgs.msg import Header

from img_recog.errors import UserError

Centroid = Optional[Tuple[float, float]]
_NO_CENTROID = (math.nan, math.nan)


class ColorDetectionError(UserError):
    """A PointCloud does not have the format of this module."""


class ColorDetection(NamedTuple):
    """Name, area in pixels and centroid of each color: (x, y) in pixels, None without pixels."""

    names: List[str]
    areas_px: List[int]
    centroids: List[Centroid]


def to_msg(names: Sequence[str], areas_px: Sequence[int], centroids: Sequence[Centroid],
           header: Header) -> PointCloud:
    """Return the message for the colors of one image; all sequences have the same order.

    header: of the image. Values are float32: areas above 2**24 pixels are rounded.

    >>> msg = to_msg(['blue', 'red'], [1600, 0], [(29.5, 119.5), None], Header())
    >>> [(channel.name, channel.values) for channel in msg.channels]
    [('blue', [1600.0, 0.0]), ('red', [0.0, 0.0])]
    """
    points = [Point32(*(centroid or _NO_CENTROID), 0.0) for centroid in centroids]
    channels = [ChannelFloat32(name, [0.0] * len(names)) for name in names]
    for number, area_px in enumerate(areas_px):
        channels[number].values[number] = float(area_px)
    return PointCloud(header, points, channels)


def from_msg(msg: PointCloud) -> ColorDetection:
    """Return the colors in a message.

    >>> from_msg(to_msg(['blue'], [1600], [(29.5, 119.5)], Header()))
    ColorDetection(names=['blue'], areas_px=[1600], centroids=[(29.5, 119.5)])

    Raises ColorDetectionError if there is not one channel for each point, with one value for each
    point, or an area is no number.
    """
    count = len(msg.points)
    lengths = [len(channel.values) for channel in msg.channels]
    if lengths != [count] * count:
        raise ColorDetectionError(
            'PointCloud has {} points and channels with {} values, expected a channel for each '
            'point, with a value for each point'.format(count, lengths))
    areas_px = [channel.values[number] for number, channel in enumerate(msg.channels)]
    if not all(map(math.isfinite, areas_px)):
        raise ColorDetectionError('PointCloud has the areas {}, expected finite numbers'.format(
            areas_px))
    return ColorDetection(
        [channel.name for channel in msg.channels],
        [int(area_px) for area_px in areas_px],
        [None if math.isnan(point.x) else (point.x, point.y) for point in msg.points])
