"""sensor_msgs/PointCloud to and from the areas and centroids of colours."""
import math
from typing import List, Optional, Sequence, Tuple

from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, PointCloud
from std_msgs.msg import Header

_NOWHERE = (math.nan, math.nan)


def to_msg(header: Header, names: Sequence[str], areas_px: Sequence[int],
           centroids: Sequence[Optional[Tuple[float, float]]]) -> PointCloud:
    """Return the message."""
    return PointCloud(
        header=header, points=[Point32(*(each or _NOWHERE), 0.0) for each in centroids],
        channels=[ChannelFloat32(name, [float(area_px) if other == number else 0.0
                                        for other in range(len(names))])
                  for number, (name, area_px) in enumerate(zip(names, areas_px))])
