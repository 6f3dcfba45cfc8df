"""A simulation in figures, by the names that Gazebo gives: what simulate.py prints."""
from typing import Dict, Iterator, List, Mapping, NamedTuple, Tuple

import numpy as np
import pybullet

from img_recog.errors import SimulationError
from img_recog.formats.sdf_models import BETWEEN_AXES
from img_recog.model import NO_INERTIA, Frame, Inertia, Model
from img_recog.rotations import Quaternion
from img_recog.simulation.models import LINK_SEPARATOR
from img_recog.simulation.physics.body import Body, FrameState, Vector, velocity_at
from img_recog.simulation.physics.client import link_indices
from img_recog.simulation.physics.world import FLOOR
from img_recog.simulation.simulator import Simulator


class _Link(NamedTuple):
    """A link: the body, and the number of the part that carries it with its pose by `in_part`."""

    body: Body
    part: int
    pose: Tuple[Vector, Quaternion]


class Figures:
    """The links and joints of all models of a simulator, as long as nothing is added or removed.

    Names are MODEL::LINK and MODEL::JOINT.
    """

    def __init__(self, simulator: Simulator):
        self._client = {'physicsClientId': simulator.world.physics_client_id}
        self._links: Dict[str, _Link] = {}
        self._joints: Dict[str, Tuple[Body, int]] = {}
        self._held: List[str] = []
        self._inertias: Dict[str, Inertia] = {}
        world = simulator.world
        if world.floor:
            self._add(FLOOR.name, world.floor, FLOOR.model, FLOOR.model.frames)
        for tree, body in zip(world.file.trees, world.bodies):
            self._add(tree.name.partition(LINK_SEPARATOR)[0], body, tree.model, tree.model.frames)
        for vehicle in simulator.vehicles:
            # like Gazebo, without the links that are lumped into others
            self._add(vehicle.robot.name, vehicle.robot, vehicle.model, {
                link: frame for link, frame in vehicle.model.frames.items()
                if link == frame.link})

    def _add(self, name: str, body: Body, model: Model, frames: Mapping[str, Frame]) -> None:
        prefix = name + LINK_SEPARATOR
        indices = link_indices(body.body_id, body.physics_client_id)
        for link, (part, pose) in frames.items():
            number = indices[part]
            self._links[prefix + link] = _Link(body, number, body.in_part(number, pose))
        self._inertias.update((prefix + link.name, link.inertia or NO_INERTIA)
                              for link in model.links if link.name in frames)
        for joint, index in body.joints.items():
            self._joints[prefix + joint] = body, index
        self._held += [prefix + joint for joint in model.held]

    def links(self) -> Dict[str, List[float]]:
        """Return x, y, z (m), a quaternion x, y, z, w, the velocity of the frame (m/s) and its
        angular velocity (rad/s) of each link, 13 numbers in the world.
        """
        return {name: list(_numbers(link.body.part_state(link.part, link.pose)))
                for name, link in self._links.items()}

    def joints(self) -> Dict[str, List[float]]:
        """Return position and velocity of each axis of each joint: rad and rad/s, or m and m/s."""
        found: Dict[str, List[float]] = {name: [] for name in self._held}
        for name, (body, index) in self._joints.items():
            found.setdefault(name.partition(BETWEEN_AXES)[0], []).extend(
                pybullet.getJointState(body.body_id, index, **self._client)[:2])
        return found

    def masses(self) -> Dict[str, List[float]]:
        """Return mass (kg) and moments of inertia (kg m2) of each link, about its center of mass.

        The axes are those that its file gives them in.
        """
        return {name: [inertia.mass, *np.diag(inertia.matrix).tolist()]
                for name, inertia in self._inertias.items()}

    def set_motor(self, joint: str, velocity: float, limit: float) -> None:
        """Let a motor hold a joint at a velocity, in rad/s or m/s.

        limit: its torque in N m or force in N. Raises SimulationError if there is no such joint.
        """
        if joint not in self._joints:
            raise SimulationError('no movable joint {} (movable joints: {})'.format(
                joint, ', '.join(self._joints) or 'none'))
        body, index = self._joints[joint]
        pybullet.setJointMotorControl2(body.body_id, index, pybullet.VELOCITY_CONTROL,
                                       targetVelocity=velocity, force=limit, **self._client)


def _numbers(state: FrameState) -> Iterator[float]:
    (position, orientation), point, linear, angular = state
    yield from position
    yield from orientation
    yield from velocity_at(position, point, linear, angular)
    yield from angular
