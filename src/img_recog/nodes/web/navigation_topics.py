"""What pages show of SLAM and navigation: map, place of the robot in it and plans; and goals."""
import base64
import math
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Transform
from nav_msgs.msg import OccupancyGrid, Path
from rospy.numpy_msg import numpy_msg
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from img_recog import rotations
from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.nodes.web.measurements import Topic, WatchedTopics, number, rounded
from img_recog.nodes.web.simulation_service import place_to_msg
from img_recog.ros.throttle import ThrottledWarning

try:
    from map_msgs.msg import OccupancyGridUpdate
except ImportError:     # it is not installed, and who publishes such updates is not either
    OccupancyGridUpdate = None

_MAX_CELLS = 4096 * 4096
_MAX_PLANS, _MAX_POINTS = 8, 500
_UNKNOWN = -1
# gray of each value of a cell as an unsigned byte: like the images of map_saver
_GRAYS = np.full(256, 205, np.uint8)
_GRAYS[:101] = np.linspace(254, 0, 101).round()


class NavigationTopics(WatchedTopics):
    """The map of a robot and what is in it, while somebody publishes it and somebody looks.

    updates: map, with the cells as PNG; origin: the pose of the frame of the odometry in the frame
    of the map; plans: of the topics of type nav_msgs/Path.
    """

    def __init__(self, resolve: Callable[[str], str], odom_frame: Callable[[], str]):
        """Subscribe to nothing yet.

        resolve: returns the full name of a topic of the robot; without a map there, the one of all
        robots is shown. odom_frame: returns the frame of the odometry, '' if it is not known.
        """
        super().__init__()
        self._resolve, self._odom_frame = resolve, odom_frame
        self._plans: Dict[str, Any] = {}
        self._transforms: Dict[Tuple[str, str], Transform] = {}
        self._shown: Optional[Transform] = None
        self._header, self._origin = Header(), PlanePose(0.0, 0.0, 0.0)
        self._resolution_m, self._grid = 0.0, np.empty((0, 0), np.int8)
        self._goals: Optional[rospy.Publisher] = None
        self._initial_poses: Optional[rospy.Publisher] = None
        self._warn = ThrottledWarning()

    @property
    def has_map(self) -> bool:
        """Whether somebody publishes a map."""
        return bool(self._topics)

    def follow(self, types: Mapping[str, str]) -> None:
        """Show what is published; types: by the names of the topics."""
        grids = [name for name in (self._resolve('map'), rospy.resolve_name('map'))
                 if types.get(name) == 'nav_msgs/OccupancyGrid']
        self._topics = self._found(grids[0], types) if grids else []
        if grids and self._goals is None:
            self._initial_poses = rospy.Publisher(
                self._resolve('initialpose'), PoseWithCovarianceStamped, queue_size=1)
            self._goals = rospy.Publisher(
                self._resolve('move_base_simple/goal'), PoseStamped, queue_size=1)
        self.watch(self._is_watched)

    def _found(self, grid: str, types: Mapping[str, str]) -> List[Topic]:
        plans = sorted(name for name, kind in types.items() if kind == 'nav_msgs/Path'
                       and name.startswith(self._resolve('map')[:-len('map')]))
        updates = grid + '_updates'
        return [(grid, numpy_msg(OccupancyGrid), self._mapped),
                *([(updates, numpy_msg(OccupancyGridUpdate), self._changed)]
                  if OccupancyGridUpdate is not None
                  and types.get(updates) == 'map_msgs/OccupancyGridUpdate' else []),
                ('/tf', TFMessage, self._moved), ('/tf_static', TFMessage, self._moved),
                *((name, Path, partial(self._planned, name)) for name in plans[:_MAX_PLANS])]

    def _forget(self) -> None:
        super()._forget()
        self._plans.clear()
        self._transforms.clear()
        self._shown = None

    def _mapped(self, msg: Any) -> None:
        info = msg.info
        size = info.width * info.height
        if not (0 < size <= _MAX_CELLS and size == len(msg.data)
                and 0 < info.resolution < math.inf):
            self._warn('map: %d x %d cells of %g m with %d values, expected 1 to %d cells with '
                       'one value each', info.width, info.height, info.resolution, len(msg.data),
                       _MAX_CELLS)
            return
        try:
            origin = plane_msgs.pose_from_msg(PoseStamped(pose=info.origin))
        except plane_msgs.PoseError as error:
            self._warn('map: %s', error)
            return
        self._header, self._resolution_m, self._origin = msg.header, info.resolution, origin
        self._grid = np.array(msg.data, np.int8).reshape(info.height, info.width)
        self._show_map()

    def _changed(self, msg: Any) -> None:
        rows, columns = (slice(first, first + count) for first, count in (
            (msg.y, msg.height), (msg.x, msg.width)))
        if (msg.x < 0 or msg.y < 0 or len(msg.data) != msg.width * msg.height
                or self._grid[rows, columns].shape != (msg.height, msg.width)):
            self._warn('an update of the map: %d x %d cells at %d, %d with %d values, expected '
                       'cells of the map', msg.width, msg.height, msg.x, msg.y, len(msg.data))
            return
        self._grid[rows, columns] = np.reshape(msg.data, (msg.height, msg.width))
        self._show_map()

    def _show_map(self) -> None:
        """Show the part of the map in which something is known."""
        known = self._grid != _UNKNOWN
        rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return
        part = self._grid[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]
        corner = PlanePose(columns[0] * self._resolution_m,
                           rows[0] * self._resolution_m, 0.0)
        _, png = cv2.imencode('.png', _GRAYS[part.view(np.uint8)])
        self.updates.set('map', {
            'corner': rounded(*self._origin.compose(corner)),
            'resolution': self._resolution_m, 'png': base64.b64encode(png).decode()})

    def _moved(self, msg: TFMessage) -> None:
        for each in msg.transforms:
            frames = each.header.frame_id.lstrip('/'), each.child_frame_id.lstrip('/')
            self._transforms[frames] = each.transform
        # a static one comes once, maybe before the frames of map and odometry are known
        transform = self._transforms.get((self._header.frame_id.lstrip('/'),
                                          self._odom_frame().lstrip('/')))
        if transform is None or transform is self._shown:
            return      # /tf is mostly about other frames
        self._shown, place, turn = transform, transform.translation, transform.rotation
        pose = rounded(place.x, place.y, rotations.yaw((turn.x, turn.y, turn.z, turn.w)))
        if None not in pose:
            self.updates.set('origin', pose)

    def _planned(self, name: str, msg: Path) -> None:
        poses = msg.poses[::1 + len(msg.poses) // _MAX_POINTS]
        points = [(number(each.pose.position.x), number(each.pose.position.y)) for each in poses]
        self._plans[name] = {
            'in_odom': msg.header.frame_id.lstrip('/') == self._odom_frame().lstrip('/'),
            'points': [point for point in points if None not in point]}
        self.updates.set('plans', list(self._plans.values()))

    def publish(self, x: float, y: float, yaw: float, is_initial: bool) -> None:
        """Send a goal, or where the robot is; m and rad in the frame of the map.

        Raises UserError for a place that is not allowed.
        """
        msg = place_to_msg(x, y, yaw, self._header.frame_id)
        if self._goals is None or self._initial_poses is None:
            return
        if is_initial:
            self._initial_poses.publish(plane_msgs.initial_pose(msg))
        else:
            self._goals.publish(msg)
