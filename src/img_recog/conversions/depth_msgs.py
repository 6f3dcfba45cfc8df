"""Conversion of depths to sensor_msgs/Image, and to and from sensor_msgs/PointCloud2."""
import sys
from typing import Tuple

import cv2
import numpy as np
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

MILLIMETERS = '16UC1'       # REP 118; the other encoding is 32FC1, in m
# as of libgazebo_ros_depth_camera: 4 bytes after z and 12 after the color are not used
POINT_BYTES = 32
_POINT = np.dtype({'names': ['xyz', 'bgr'], 'formats': ['3f4', '3u1'], 'offsets': [0, 16],
                   'itemsize': POINT_BYTES})
_FIELDS = tuple(PointField(name, offset, PointField.FLOAT32, 1)
                for name, offset in (('x', 0), ('y', 4), ('z', 8), ('rgb', 16)))


def within(depths: np.ndarray, limits: Tuple[float, float]) -> np.ndarray:
    """Return depths, NaN for those that have no point, as in Gazebo.

    depths: float32, in m, +inf for nothing; limits: the smallest and the largest one that is told
    (pointCloudCutoff and pointCloudCutoffMax of gazebo_plugins).
    """
    return np.where((depths > limits[0]) & (depths < limits[1]), depths, np.float32(np.nan))


def to_bytes(depths: np.ndarray, encoding: str) -> np.ndarray:
    """Return the bytes (height, width, n) of an image of depths.

    depths: float32, in m, NaN for nothing. In 16UC1, that and what is 65.5 m away are 0.

    >>> to_bytes(np.array([[1.5, np.nan]], np.float32), '16UC1').view(np.uint16).tolist()
    [[[1500], [0]]]
    """
    if encoding == MILLIMETERS:
        depths = np.round(depths * 1000)
        depths = np.where(depths < 1 << 16, depths, 0).astype(np.uint16)
    return depths.view(np.uint8).reshape(*depths.shape, -1)


def cloud_without_points(depths: np.ndarray, header: Header) -> PointCloud2:
    """Return a message for a point with a color for each pixel, without data.

    depths: float32 (height, width), NaN for nothing.
    """
    height, width = depths.shape
    return PointCloud2(header=header, height=height, width=width, fields=list(_FIELDS),
                       is_bigendian=sys.byteorder == 'big', point_step=POINT_BYTES,
                       row_step=POINT_BYTES * width, is_dense=not np.isnan(depths).any())


def draw_points(result: np.ndarray, depths: np.ndarray, image: np.ndarray,
                slopes: Tuple[np.ndarray, np.ndarray]) -> None:
    """Write the data of such a message; NaN is nothing.

    result: uint8 (height, width, POINT_BYTES); depths: float32 (height, width), m along the
    optical axis, NaN for nothing; image: uint8 RGB; slopes: x to the right and y downward of what
    each pixel sees, at z 1, float32 (height, width).
    """
    x, y = (cv2.multiply(depths, slope) for slope in slopes)
    color = cv2.cvtColor(image, cv2.COLOR_RGB2BGRA)
    color[..., 3] = 0
    # one pass over all points: they are much more memory than what they are made of; -1 is zero
    cv2.mixChannels([x, y, depths, color.view(np.float32)], [result.view(np.float32)],
                    [0, 0, 1, 1, 2, 2, -1, 3, 3, 4, -1, 5, -1, 6, -1, 7])


def from_msg(msg: PointCloud2) -> Tuple[np.ndarray, np.ndarray]:
    """Return the points (height, width, 3) in m of such a message, and their colors, uint8 RGB."""
    points = np.frombuffer(msg.data, _POINT).reshape(msg.height, msg.width)
    return points['xyz'], points['bgr'][..., ::-1]
