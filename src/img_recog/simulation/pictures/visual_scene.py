"""What a simulation looks like: its visuals, and the poses of the parts that carry them."""
from typing import Dict, List, Tuple

import numpy as np
import pybullet

from img_recog.model import Visual, VisualScene
from img_recog.simulation.physics.body import Body
from img_recog.simulation.simulator import Simulator


class Parts:
    """The links of all bodies of a simulation: what its visuals are attached to.

    moving: whether the part of each number can move. The order is that of the bodies of the
    world, and of their links, the root link first.
    """

    def __init__(self, simulator: Simulator):
        self._simulator = simulator
        self.refresh()

    def refresh(self) -> None:
        """Read the bodies again; to be called when some were added or removed, or can move now."""
        simulator = self._simulator
        self._bodies: List[Body] = list(simulator.world.bodies)
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
        return [{name: number for number, name in enumerate(body.link_indices, rows.start)}
                for body, rows in zip(self._bodies, self._rows)]

    def scene(self) -> VisualScene:
        """Return what there is to draw."""
        world = self._simulator.world
        links = [(numbers[link.name], link) for tree, numbers in zip(world.trees, self.numbers())
                 for link in tree.model.links]
        visuals = tuple(Visual(number, look.shape, look.pose.matrix(), look.material,
                               look.prefers_file, look.opacity)
                        for number, link in links for look in link.looks)
        lights = [(number, light) for number, link in links for light in link.lights]
        return VisualScene(visuals, self.moving,
                           (*((-1, light) for light in world.file.lights), *lights),
                           world.file.surroundings, world.file.has_floor)


def _moving(body: Body) -> List[bool]:
    return [not body.fixed or body.was_moved or (link != -1 and bool(body.joints))
            for link in body.links]


def _poses(body: Body) -> List[Tuple[float, ...]]:
    pose = body.pose()
    states = pybullet.getLinkStates(
        body.body_id, body.links[1:], computeForwardKinematics=True,
        **body.client) if len(body.links) > 1 else ()
    return [(*pose.position, *pose.orientation)] + [(*state[4], *state[5]) for state in states]
