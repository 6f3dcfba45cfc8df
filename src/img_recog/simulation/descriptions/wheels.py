"""The separation and diameter of a robot's wheels, as its URDF has them."""
import functools
import os
import xml.etree.ElementTree as ElementTree
from typing import Container, Dict, List, NamedTuple, Optional, Sequence

import cv2
import numpy as np

from img_recog import mesh_file
from img_recog.mesh_file import MeshError
from img_recog.simulation.descriptions import urdf_tree
from img_recog.simulation.descriptions.description import Description
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import read_lengths, read_number, read_numbers
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.descriptions.urdf_elements import origin_of
from img_recog.simulation.descriptions.urdf_tree import UrdfTree
from img_recog.simulation.settings import DriveSettings

_TOLERANCE = 0.05       # relative: Gazebo's tags are often rounded
_DEFAULT_DIAMETER = DriveSettings().wheel_diameter
_MIN_ROUNDNESS = 0.9    # of the nearest to the farthest corner of a mesh that is a wheel


class Wheels(NamedTuple):
    """What the URDF says, in m; None where it does not.

    swapped: whether the left joints are on the right.
    """

    wheel_separation: Optional[float] = None
    wheel_diameter: Optional[float] = None
    swapped: bool = False

    def values(self) -> Dict[str, float]:
        """Return what is known, by the name of the setting."""
        known = {'wheel_separation': self.wheel_separation, 'wheel_diameter': self.wheel_diameter}
        return {name: value for name, value in known.items() if value is not None}

    def warnings(self, drive: DriveSettings, given: Container[str]) -> List[str]:
        """Return a line for each setting that contradicts the URDF, or that had to be assumed.

        given: the names of the settings that tags give.
        """
        lines = [
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
    """Its middle (3,), and its axis (3,), a unit vector, in the frame of the root link; m."""

    middle: np.ndarray
    axis: np.ndarray
    diameter: Optional[float]


def measure(description: Description, drive: DriveSettings) -> Wheels:
    """Return how far the wheels of a robot are apart along their axis, and their diameter.

    They are measured at the collision shapes of the wheels, or at the visual shapes of wheels
    without those: at cylinders or spheres, else at meshes. Unknown joints give Wheels(): those
    are refused when the robot is loaded.
    """
    tree = urdf_tree.read(ElementTree.fromstring(description.urdf))
    links = {joint.name: link for link, joint in tree.parents.items()}
    names = drive.left_joints + drive.right_joints
    if not names or not set(names) <= set(links) or len(set(names)) < len(names):
        return Wheels()
    left, right = ([_wheel(links[name], tree) for name in side]
                   for side in (drive.left_joints, drive.right_joints))
    # to the micrometer: the rest is rounding
    separation = round(float(left[0].axis @ (_middle(left) - _middle(right))), 6)
    diameters = {wheel.diameter for wheel in left + right}
    return Wheels(abs(separation) or None, diameters.pop() if len(diameters) == 1 else None,
                  separation < 0)


def _middle(side: Sequence[_Wheel]) -> np.ndarray:
    return sum(wheel.middle for wheel in side) / len(side)      # type: ignore


def _wheel(link: str, tree: UrdfTree) -> _Wheel:
    frame, axis = _pose(link, tree), axis_of(tree.parents[link].element)
    shapes = tree.links[link]
    middle, diameter = _measured(shapes.findall('collision') or shapes.findall('visual'), axis)
    return _Wheel(frame.apply(middle), frame.rotation @ axis, diameter)


def _pose(link: str, tree: UrdfTree) -> Transform:
    """Return the pose of a link in the frame of the root link."""
    pose = IDENTITY
    while link != tree.root:
        pose = origin_of(tree.parents[link].element) @ pose
        link = tree.parents[link].parent_link
    return pose


def _measured(shapes: List[ElementTree.Element],
              axis: np.ndarray) -> 'tuple[np.ndarray, Optional[float]]':
    """Return the middle (3,) of a wheel in its link, and its diameter.

    axis (3,): of the joint, a unit vector in the link.
    """
    for shape in shapes:
        for tag in ('cylinder', 'sphere'):
            element = shape.find('geometry/' + tag)
            if element is not None:
                radius = read_number('radius of a wheel', element.get('radius'))
                return origin_of(shape).translation, round(2 * radius, 6)
    for shape in shapes:
        outline = mesh_outline(shape, axis)
        if outline is not None:
            return outline.middle, outline.diameter
    return np.zeros(3), None


class Outline(NamedTuple):
    """Of a mesh about an axis, in m: its middle (3,), a point of the axis, its width along it, and
    its diameter, None if it is not round."""

    middle: np.ndarray
    width: float
    diameter: Optional[float]


def mesh_outline(shape: ElementTree.Element, axis: np.ndarray) -> Optional[Outline]:
    """Return the outline of a shape of a wheel, None if it is no mesh that can be read.

    axis (3,): of the joint, a unit vector through the origin of the link.
    """
    mesh = shape.find('geometry/mesh')
    if mesh is None:
        return None
    path, pose = mesh.get('filename', ''), origin_of(shape)
    scale = read_lengths('scale of a wheel', mesh.get('scale', '1 1 1'), 3)
    try:
        corners = (_corners(path, _changed_at(path)) * scale) @ pose.rotation.T + pose.translation
    except MeshError:
        return None         # it is refused where it is needed
    along = corners @ axis
    first, last = float(along.min()), float(along.max())
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    plane = np.column_stack((corners @ across, corners @ np.cross(axis, across)))
    distances = np.linalg.norm(cv2.convexHull(plane.astype(np.float32))[:, 0], axis=1)
    radius = float(distances.max())
    is_round = distances.min() >= _MIN_ROUNDNESS * radius
    return Outline(axis * (first + last) / 2, last - first,
                   round(2 * radius, 6) if is_round else None)


@functools.lru_cache(maxsize=8)         # the wheels of a robot often share one
def _corners(path: str, _: float) -> np.ndarray:
    """Return the corners (n, 3) of a mesh file in m; MeshError when it cannot be read."""
    return np.concatenate([part.positions.reshape(-1, 3) for part in mesh_file.read(path)])


def _changed_at(path: str) -> float:
    return os.path.getmtime(path) if os.path.exists(path) else 0.0


def axis_of(joint: ElementTree.Element) -> np.ndarray:
    """Return the axis (3,) of a URDF's joint in the frame of its link, a unit vector."""
    element = joint.find('axis')
    text = '1 0 0' if element is None else element.get('xyz', '1 0 0')
    axis = read_numbers('axis of joint ' + name_of(joint), text, 3)
    return axis / np.linalg.norm(axis)
