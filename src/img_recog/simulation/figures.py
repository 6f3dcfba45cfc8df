"""A simulation in figures, by the names that Gazebo gives: what simulate.py prints."""
from typing import Dict, Iterator, List

import numpy as np

from img_recog.errors import SimulationError
from img_recog.formats.sdf_models import BETWEEN_AXES
from img_recog.model import NO_INERTIA
from img_recog.simulation.models import LINK_SEPARATOR, Models
from img_recog.simulation.physics.body import FrameState, velocity_at
from img_recog.simulation.simulator import Simulator


class Figures:
    """The links and joints of all models of a simulation, as long as nothing is added or removed.

    Names are MODEL::LINK and MODEL::JOINT.
    """

    def __init__(self, simulator: Simulator):
        self._bodies = [(model + LINK_SEPARATOR, body) for model, body in Models(simulator).bodies]
        self._joints = {prefix + joint: (body, joint) for prefix, body in self._bodies
                        for joint in body.joints}

    def links(self) -> Dict[str, List[float]]:
        """Return x, y, z (m), a quaternion x, y, z, w, the velocity of the frame (m/s) and its
        angular velocity (rad/s) of each link, 13 numbers in the world.
        """
        return {prefix + link: list(_numbers(body.frame_state(link)))
                for prefix, body in self._bodies for link in body.link_names}

    def joints(self) -> Dict[str, List[float]]:
        """Return position and velocity of each axis of each joint: rad and rad/s, or m and m/s."""
        found: Dict[str, List[float]] = {
            prefix + joint: [] for prefix, body in self._bodies for joint in body.model.held}
        for name, (body, joint) in self._joints.items():
            found.setdefault(name.partition(BETWEEN_AXES)[0], []).extend(body.joint_state(joint))
        return found

    def masses(self) -> Dict[str, List[float]]:
        """Return mass (kg) and moments of inertia (kg m2) of each link, about its center of mass.

        The axes are those that its file gives them in.
        """
        inertias = {prefix + link.name: link.inertia or NO_INERTIA
                    for prefix, body in self._bodies for link in body.model.links
                    if link.name in body.link_names}
        return {name: [inertia.mass, *np.diag(inertia.matrix).tolist()]
                for name, inertia in inertias.items()}

    def set_motor(self, joint: str, velocity: float, limit: float) -> None:
        """Let a motor hold a joint at a velocity, in rad/s or m/s.

        limit: its torque in N m or force in N. Raises SimulationError if there is no such joint.
        """
        if joint not in self._joints:
            raise SimulationError('no movable joint {} (movable joints: {})'.format(
                joint, ', '.join(self._joints) or 'none'))
        body, name = self._joints[joint]
        body.set_motor(name, velocity, limit)


def _numbers(state: FrameState) -> Iterator[float]:
    (position, orientation), point, linear, angular = state
    yield from position
    yield from orientation
    yield from velocity_at(position, point, linear, angular)
    yield from angular
