"""What a simulation looks like: its visuals, and the poses of the parts that carry them."""
import collections
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, Optional, Tuple

import numpy as np
import pybullet

from img_recog.simulation import link_materials, sdf_shapes, urdf_shapes
from img_recog.simulation.body import Body
from img_recog.simulation.description import origin_of
from img_recog.simulation.loading import link_indices
from img_recog.simulation.numbers import read_numbers
from img_recog.simulation.scene import Scene
from img_recog.simulation.simulator import Simulator
from img_recog.visuals import MESH, PLANE, Light, Material, Shape, Visual, VisualScene

# the direction to the sun: the opposite of <direction> of Gazebo's default sun
SUN = (0.5, -0.1, 0.9)
# less saturated than any color that the recognition counts
_HORIZON, _ZENITH = (0.78, 0.8, 0.82), (0.64, 0.74, 0.86)


class Parts:
    """The links of all bodies of a simulation: what its visuals are attached to.

    moving: whether the part of each number can move. The order is that of the bodies, robots
    first, and of their links, the root link first.
    """

    def __init__(self, simulator: Simulator):
        self._simulator = simulator
        self.refresh()

    def refresh(self) -> None:
        """Read the bodies again; to be called when some were added, removed or rearranged."""
        simulator = self._simulator
        self._bodies: List[Body] = [*(vehicle.robot for vehicle in simulator.vehicles),
                                    *simulator.world.bodies]
        self.moving = tuple(moving for body in self._bodies for moving in _moving(body))
        self._poses = np.array([pose for body in self._bodies for pose in _poses(body)],
                               float).reshape(-1, 7)
        starts = np.cumsum([0] + [len(body.links) for body in self._bodies])
        self._rows = [slice(start, start + len(body.links))
                      for body, start in zip(self._bodies, starts)]

    def poses(self) -> np.ndarray:
        """Return the poses (n, 7) now: x, y, z in m and a unit quaternion x, y, z, w."""
        for body, rows in zip(self._bodies, self._rows):
            if any(self.moving[rows]):
                self._poses[rows] = _poses(body)
        return self._poses.copy()

    def numbers(self) -> List[Dict[str, int]]:
        """Return the numbers of the links of each body, by name."""
        return [{name: number for number, name in enumerate(
            link_indices(body.body_id, body.physics_client_id), rows.start)}
                for body, rows in zip(self._bodies, self._rows)]


def read(scene: Scene, parts: Parts) -> VisualScene:
    """Return what there is to draw; SimulationError when a number in it is wrong."""
    texts = [robot.urdf for robot in scene.robots] + [tree.urdf for tree in scene.world.trees]
    visuals = [visual for text, numbers in zip(texts, parts.numbers())
               for visual in _visuals(text, numbers)]
    return VisualScene(tuple(visuals), parts.moving,
                       Light(SUN, _HORIZON, scene.world.has_floor, zenith=_ZENITH))


def check(urdf: str) -> None:
    """Raise SimulationError when a number in a visual of a URDF is wrong."""
    for _ in _visuals(urdf, collections.defaultdict(int)):
        pass


def _visuals(urdf: str, numbers: Dict[str, int]) -> Iterator[Visual]:
    """Yield the visuals of a URDF; numbers: of its links, by name."""
    robot = ElementTree.fromstring(urdf)
    named = {material.get('name'): material for material in robot.findall('material')}
    for link in robot.findall('link'):
        for element in link.findall('visual'):
            yield _visual(element, numbers[link.get('name', '')], named)


def _moving(body: Body) -> List[bool]:
    return [not body.fixed or (link != -1 and bool(body.joints)) for link in body.links]


def _poses(body: Body) -> List[Tuple[float, ...]]:
    pose = body.pose()
    states = pybullet.getLinkStates(
        body.body_id, body.links[1:], computeForwardKinematics=True,
        physicsClientId=body.physics_client_id) if len(body.links) > 1 else ()
    return [(*pose.position, *pose.orientation)] + [(*state[4], *state[5]) for state in states]


def _visual(element: ElementTree.Element, part: int,
            named: Dict[Optional[str], ElementTree.Element]) -> Visual:
    shape, given = urdf_shapes.read(element), element.find('material')
    pose = origin_of(element).matrix()
    box = element.find('geometry/box')
    if box is not None and box.get(sdf_shapes.PLANE):
        x, y, z = shape.size
        shape, pose[:3, 3] = Shape(PLANE, (x, y)), pose[:3, 3] + pose[:3, 2] * z / 2
    return Visual(part, shape, pose, _material(element, named),
                  shape.kind == MESH and given is not None
                  and given.get(link_materials.REPLACES) is None)


def _material(visual: ElementTree.Element,
              named: Dict[Optional[str], ElementTree.Element]) -> Optional[Material]:
    """Return the material of a visual, None if it has none."""
    element = visual.find('material')
    if element is None:
        return None
    if element.find('color') is None and element.find('texture') is None:
        element = named.get(element.get('name'), element)
    color, texture = element.find('color'), element.find('texture')
    red, green, blue, opacity = read_numbers(
        'rgba of material ' + element.get('name', ''),
        '1 1 1 1' if color is None else color.get('rgba'), 4).tolist()
    path = '' if texture is None else texture.get('filename', '')
    return None if color is None and not path else Material((red, green, blue, opacity), path)
