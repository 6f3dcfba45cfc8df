"""The separation and diameter of a robot's wheels, as its URDF has them."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple, Optional

import numpy as np

from img_recog.simulation.descriptions.description import Description
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import read_number, read_numbers
from img_recog.simulation.descriptions.urdf_elements import origin_of
from img_recog.simulation.settings import DriveSettings

_TOLERANCE = 0.05       # relative: Gazebo's tags are often rounded


class Wheels(NamedTuple):
    """What the URDF says, in m; None where it does not."""

    wheel_separation: Optional[float] = None
    wheel_diameter: Optional[float] = None

    def values(self) -> Dict[str, float]:
        """Return what is known, by the name of the setting."""
        return {name: value for name, value in self._asdict().items() if value is not None}

    def contradictions(self, drive: DriveSettings) -> List[str]:
        """Return a line for each setting that is not what the URDF says."""
        return ['{} is {:g} m, but in the URDF it is {:g} m: the robot will move at another speed '
                'than commanded'.format(name, getattr(drive, name), value)
                for name, value in self.values().items()
                if abs(getattr(drive, name) - value) > _TOLERANCE * value]


def measure(description: Description, drive: DriveSettings) -> Wheels:
    """Return how far the wheels of a robot are apart along their axis, and their diameter.

    They are measured at the collision shapes of the wheels, cylinders or spheres. Unknown joints
    give Wheels(): those are refused when the robot is loaded.
    """
    robot = ElementTree.fromstring(description.urdf)
    joints = {joint.get('name'): joint for joint in robot.findall('joint')}
    left, right = joints.get(drive.left_joint), joints.get(drive.right_joint)
    if left is None or right is None or left is right:
        return Wheels()
    links = {link.get('name', ''): link for link in robot.findall('link')}
    parents = {_end(joint, 'child'): joint for joint in joints.values()}
    middles, diameters, axes = [], [], []
    for joint in (left, right):
        frame = _pose(joint, parents)
        shape, diameter = _shape(links[_end(joint, 'child')])
        middles.append(frame.apply(shape.translation))
        diameters.append(diameter)
        axes.append(frame.rotation @ _axis(joint))
    # to the micrometer: the rest is rounding
    separation = round(abs(float(axes[0] @ (middles[0] - middles[1]))), 6)
    same = diameters[0] is not None and diameters[0] == diameters[1]
    return Wheels(separation if separation > 0 else None, diameters[0] if same else None)


def _end(joint: ElementTree.Element, tag: str) -> str:
    element = joint.find(tag)
    return '' if element is None else element.get('link', '')


def _pose(joint: ElementTree.Element, parents: Dict[str, ElementTree.Element]) -> Transform:
    """Return the pose of a joint in the frame of the root link."""
    pose = origin_of(joint)
    link = _end(joint, 'parent')
    while link in parents:
        pose = origin_of(parents[link]) @ pose
        link = _end(parents[link], 'parent')
    return pose


def _shape(link: ElementTree.Element) -> 'tuple[Transform, Optional[float]]':
    """Return the pose in a wheel of its first round shape, and the diameter of that."""
    for shape in link.findall('collision'):
        for tag in ('cylinder', 'sphere'):
            element = shape.find('geometry/' + tag)
            if element is not None:
                radius = read_number('radius of the wheel ' + link.get('name', ''),
                                     element.get('radius'))
                return origin_of(shape), round(2 * radius, 6)
    return IDENTITY, None


def _axis(joint: ElementTree.Element) -> np.ndarray:
    element = joint.find('axis')
    text = '1 0 0' if element is None else element.get('xyz', '1 0 0')
    axis = read_numbers('axis of joint ' + joint.get('name', ''), text, 3)
    return axis / np.linalg.norm(axis)
