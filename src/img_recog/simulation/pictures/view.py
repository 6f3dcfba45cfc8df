"""Where the simulation is seen from: by ~view/image_raw and by the window."""
import math
from typing import NamedTuple, Sequence, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.model import BODY_TO_OPENGL
from img_recog.rotations import Transform
from img_recog.simulation.physics.body import Body, BodyPose
from img_recog.simulation.physics.world import World

FIELD_OF_VIEW = 46.8            # degrees, vertical: 60 horizontally at 4:3, like Gazebo's camera
_FOLLOW_DISTANCE_M = 1.3        # distance and pitch look over the walls of turtlebot3_world
_FOLLOW_PITCH_DEG = -68.0
_MIN_DISTANCE_M, _MAX_DISTANCE_M = 0.5, 50.0
_MAX_HEIGHT_M = 300.0           # to show all of a large world
_MIN_FAR_M, _MAX_FAR_M = 60.0, 1000.0
_NEAR_SHARE = 1 / 1200          # of the far distance: with 24 bits, depths are exact to 0.1 %
_MIN_ROOM_M = 1.5               # what is lower above the floor of a robot is furniture, no roof
_ROOF_MARGIN_M = 0.02
# of the places above a robot, in m in x and y, that a roof covers: a door or a lamp is smaller
_UNDER_ROOF = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
_MAX_FLAT_M = 0.01


class Viewpoint(NamedTuple):
    """A camera like that of pybullet.computeViewMatrixFromYawPitchRoll.

    target: m, in the world; distance: m; yaw, pitch: degrees.
    """

    target: Tuple[float, float, float]
    distance: float
    yaw: float
    pitch: float

    def pose(self) -> np.ndarray:
        """Return the pose (4, 4) in the world of a camera that looks along its x axis."""
        view = np.reshape(pybullet.computeViewMatrixFromYawPitchRoll(
            self.target, self.distance, self.yaw, self.pitch, 0, 2), (4, 4)).T
        return Transform(view[:3, :3], view[:3, 3]).inverse.matrix() @ BODY_TO_OPENGL


# like Gazebo's user camera of turtlebot3_world: straight down from (0.8, 0, 12), x upwards
ABOVE = Viewpoint(target=(0.8, 0.0, 0.0), distance=12.0, yaw=-90.0, pitch=-89.99)


def above(world: World) -> Viewpoint:
    """Return a viewpoint that shows a world.

    It is that of Gazebo's user camera in the file of the world, else ABOVE. One that looks
    straight down is farther away where it would not show all that stands in the world.
    """
    camera = world.file.camera
    viewpoint = ABOVE if camera is None else of_camera(camera)
    boxes = [np.array(pybullet.getAABB(body.body_id, link, **body.client))
             for body in world.scenery if not body.is_plane for link in body.links]
    boxes = [box for box in boxes if box[1, 2] > _MAX_FLAT_M]       # not a floor
    if not boxes or viewpoint.pitch > ABOVE.pitch or abs(viewpoint.yaw - ABOVE.yaw) > 1:
        return viewpoint
    low, high = np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]
    if camera is None and not _shows(viewpoint, low, high):
        x, y = ((low + high) / 2)[:2].tolist()
        viewpoint = viewpoint._replace(target=(x, y, 0.0))
    while not _shows(viewpoint, low, high) and viewpoint.distance < _MAX_HEIGHT_M:
        viewpoint = viewpoint._replace(distance=viewpoint.distance + 1)
    return viewpoint


def of_camera(pose: Transform) -> Viewpoint:
    """Return the viewpoint of a camera that looks along its x axis, without its roll."""
    (forward_x, forward_y, forward_z), up = pose.rotation[:, 0], pose.rotation[:, 2]
    pitch = max(math.degrees(math.asin(max(forward_z, -1.0))), ABOVE.pitch)
    # looking down, the heading is that of the upper edge of the image
    heading = (math.atan2(up[1], up[0]) if pitch < -89 else math.atan2(forward_y, forward_x))
    distance = pose.translation[2] / -forward_z if forward_z < -0.01 else _MAX_DISTANCE_M
    distance = min(max(distance, _MIN_DISTANCE_M), _MAX_DISTANCE_M)
    x, y, z = (pose.translation + distance * pose.rotation[:, 0]).tolist()
    return Viewpoint((x, y, z), distance, math.degrees(heading) - 90.0, pitch)


def _shows(viewpoint: Viewpoint, low: np.ndarray, high: np.ndarray) -> bool:
    """Return whether a box is in an image of 4:3 from `viewpoint`, which looks down like ABOVE."""
    reach = math.tan(math.radians(FIELD_OF_VIEW / 2)) * (viewpoint.distance - high[2])
    offsets = np.abs([low[:2] - viewpoint.target[:2], high[:2] - viewpoint.target[:2]]).max(axis=0)
    return bool(offsets[0] < reach and offsets[1] < reach * 4 / 3)


def near_and_far(pose: np.ndarray, slopes: Tuple[float, float]) -> Tuple[float, float]:
    """Return the distances in m along the optical axis between which there is something to see.

    They reach to the floor in all of the image, but not farther than 1 km. pose (4, 4): of the
    camera, which looks along its x axis; slopes: of the right and the upper edge.
    """
    corners = np.array([(1.0, x * slopes[0], z * slopes[1]) for x in (-1, 1) for z in (-1, 1)])
    descents = -corners @ pose[2, :3]
    height = abs(float(pose[2, 3]))
    far = max(height / descent if descent > 0 else _MAX_FAR_M for descent in descents.tolist())
    far = min(max(far * 1.05, _MIN_FAR_M), _MAX_FAR_M)
    return far * _NEAR_SHARE, far


def ceiling(world: World, robots: Sequence[Body]) -> float:
    """Return the height in m from which on nothing is to be drawn, so that the robots are seen.

    That is under the lowest roof that one of them stands under, +inf without one.
    """
    return min((_height_of_roof(body, world.physics_client_id) for body in robots),
               default=math.inf) - _ROOF_MARGIN_M


def _height_of_roof(body: Body, physics_client_id: int) -> float:
    """Return the height of the lowest point of a roof above a body, +inf without one."""
    boxes = np.array([pybullet.getAABB(body.body_id, link, physicsClientId=physics_client_id)
                      for link in body.links])
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    x, y = ((low + high) / 2)[:2].tolist()
    begin = max(float(low[2]) + _MIN_ROOM_M, float(high[2]))
    places = [(x + aside, y + ahead) for aside, ahead in _UNDER_ROOF]
    hits = pybullet.rayTestBatch([(*place, begin) for place in places],
                                 [(*place, begin + _MAX_FAR_M) for place in places],
                                 physicsClientId=physics_client_id)
    return min(hit[3][2] for hit in hits) if all(hit[0] >= 0 for hit in hits) else math.inf


def follow(pose: BodyPose) -> Viewpoint:
    """Return a viewpoint behind and above a body that looks in the body's direction."""
    heading = math.degrees(rotations.yaw(pose.orientation))
    x, y, z = pose.position
    # at yaw 0, PyBullet's camera looks along y
    return Viewpoint((x, y, z), _FOLLOW_DISTANCE_M, heading - 90.0, _FOLLOW_PITCH_DEG)


def horizontal_fov(width: int, height: int) -> float:
    """Return the horizontal field of view of an image, in rad.

    >>> round(math.degrees(horizontal_fov(640, 480)))
    60
    """
    return 2 * math.atan(math.tan(math.radians(FIELD_OF_VIEW / 2)) * width / height)
