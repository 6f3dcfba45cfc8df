"""The separation and diameter of a robot's wheels, as its URDF has them."""
import functools
import os
from typing import Container, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import cv2
import numpy as np

from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import MeshError
from img_recog.model import CYLINDER, FIXED, MESH, SPHERE, Joint, Look, Model, Solid
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.simulation_settings import DriveSettings

_TOLERANCE = 0.05       # relative: Gazebo's tags are often rounded
_DEFAULT_DIAMETER = DriveSettings().wheel_diameter
_ALONG = 0.7            # the cosine of the angle between directions that are nearly the same
_OUTER = 0.99           # share of the radius of a mesh that the corners of its tread have
_MIN_ROUNDNESS = 0.9    # of the nearest to the farthest corner of a mesh that is a wheel


class Wheels(NamedTuple):
    """What the URDF says, in m; None where it does not.

    swapped: whether the left joints are on the right; askew: joints whose wheels do not roll
    forward.
    """

    wheel_separation: Optional[float] = None
    wheel_diameter: Optional[float] = None
    swapped: bool = False
    askew: Tuple[str, ...] = ()

    def values(self) -> Dict[str, float]:
        """Return what is known, by the name of the setting."""
        known = {'wheel_separation': self.wheel_separation, 'wheel_diameter': self.wheel_diameter}
        return {name: value for name, value in known.items() if value is not None}

    def warnings(self, drive: DriveSettings, given: Container[str]) -> List[str]:
        """Return a line for each setting that contradicts the URDF, or that had to be assumed.

        given: the names of the settings that tags give.
        """
        lines = ['the wheel of {} does not roll forward: its axis, and its cylinder, must be '
                 'along the y axis of the robot'.format(name) for name in self.askew]
        lines += [
            '{} is {:g} m, but in the URDF it is {:g} m: the robot will move at another speed '
            'than commanded'.format(name, getattr(drive, name), value)
            for name, value in self.values().items()
            if abs(getattr(drive, name) - value) > _TOLERANCE * value]
        if (self.wheel_diameter is None and self.wheel_separation is not None
                and 'wheel_diameter' not in given and drive.wheel_diameter == _DEFAULT_DIAMETER):
            lines.append(
                'the URDF does not state the diameter of the wheels, and it cannot be measured: '
                '{:g} m is assumed; if that is wrong, set the parameter wheel_diameter'.format(
                    drive.wheel_diameter))
        return lines


class _Wheel(NamedTuple):
    """Its middle (3,), and its axis (3,), a unit vector, in the frame of the root link; m.

    joint: its name; is_askew: whether it does not roll forward.
    """

    joint: str
    middle: np.ndarray
    axis: np.ndarray
    diameter: Optional[float]
    is_askew: bool


def measure(model: Model, drive: DriveSettings) -> Wheels:
    """Return how far the wheels of a robot are apart along their axis, and their diameter.

    They are measured at the collision shapes of the wheels, or at the visual shapes of wheels
    without those: at cylinders or spheres, else at meshes. Unknown joints give Wheels(): those
    are refused when the robot is loaded.
    """
    joints = {joint.name: joint for joint in model.joints if joint.kind != FIXED}
    names = drive.left_joints + drive.right_joints
    if not names or not set(names) <= set(joints) or len(set(names)) < len(names):
        return Wheels()
    left, right = ([_wheel(joints[name], model) for name in side]
                   for side in (drive.left_joints, drive.right_joints))
    # to the micrometer: the rest is rounding
    separation = round(float(left[0].axis @ (_middle(left) - _middle(right))), 6)
    diameters = {wheel.diameter for wheel in left + right}
    return Wheels(abs(separation) or None, diameters.pop() if len(diameters) == 1 else None,
                  separation < 0,
                  tuple(wheel.joint for wheel in left + right if wheel.is_askew))


def _middle(side: Sequence[_Wheel]) -> np.ndarray:
    return sum(wheel.middle for wheel in side) / len(side)      # type: ignore


def _wheel(joint: Joint, model: Model) -> _Wheel:
    frame, axis = pose_in_root(joint, model), np.asarray(joint.axis)
    link, = (link for link in model.links if link.name == joint.child)
    middle, diameter = _measured(link.solids or link.looks, axis)
    turned = frame.rotation @ axis
    is_flat = any(solid.shape.kind == CYLINDER and abs(solid.pose.rotation[:, 2] @ axis) < _ALONG
                  for solid in link.solids[:1])
    return _Wheel(joint.name, frame.apply(middle), turned, diameter,
                  is_flat or abs(turned[1]) < _ALONG)


def pose_in_root(joint: Joint, model: Model) -> Transform:
    """Return the pose of the child of a joint in the frame of the root link."""
    parents, pose = {each.child: each for each in model.joints}, IDENTITY
    above: Optional[Joint] = joint
    while above is not None:
        pose, above = above.pose @ pose, parents.get(above.parent)
    return pose


def _measured(shapes: Sequence[Union[Solid, Look]],
              axis: np.ndarray) -> 'tuple[np.ndarray, Optional[float]]':
    """Return the middle (3,) of a wheel in its link, and its diameter.

    axis (3,): of the joint, a unit vector in the link.
    """
    for shape in shapes:
        if shape.shape.kind in (CYLINDER, SPHERE):
            return shape.pose.translation, round(2 * shape.shape.size[0], 6)
    for shape in shapes:
        outline = mesh_outline(shape, axis)
        if outline is not None:
            return outline.middle, outline.diameter
    return np.zeros(3), None


class Outline(NamedTuple):
    """The tread of a mesh about an axis, in m.

    Attributes:
        middle: Point of the axis (3,) in the middle of the tread.
        width: Width of the tread along the axis.
        diameter: None if the mesh is not round.
    """

    middle: np.ndarray
    width: float
    diameter: Optional[float]


def mesh_outline(shape: Union[Solid, Look], axis: np.ndarray) -> Optional[Outline]:
    """Return the outline of a shape of a wheel, None if it is no mesh that can be read.

    axis (3,): of the joint, a unit vector through the origin of the link.
    """
    (kind, scale, path, _), pose = shape.shape, shape.pose
    if kind != MESH:
        return None
    try:
        corners = (_corners(path, _changed_at(path)) * scale) @ pose.rotation.T + pose.translation
    except MeshError:
        return None         # it is refused where it is needed
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    plane = np.column_stack((corners @ across, corners @ np.cross(axis, across)))
    distances = np.linalg.norm(cv2.convexHull(plane.astype(np.float32))[:, 0], axis=1)
    radius = float(distances.max())
    # the corners that can touch a floor: the rest of a wheel, such as a hub, may be wider
    along = (corners @ axis)[np.linalg.norm(plane, axis=1) > _OUTER * radius]
    first, last = float(along.min()), float(along.max())
    is_round = distances.min() >= _MIN_ROUNDNESS * radius
    return Outline(axis * (first + last) / 2, last - first,
                   round(2 * radius, 6) if is_round else None)


@functools.lru_cache(maxsize=8)         # the wheels of a robot often share one
def _corners(path: str, _: float) -> np.ndarray:
    """Return the corners (n, 3) of a mesh file in m; MeshError when it cannot be read."""
    return np.concatenate([part.positions.reshape(-1, 3) for part in mesh_file.read(path)])


def _changed_at(path: str) -> float:
    return os.path.getmtime(path) if os.path.exists(path) else 0.0
