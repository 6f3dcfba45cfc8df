"""A simulation in figures, by the names that Gazebo gives: what simulate.py prints."""
from typing import Dict, Iterator, List, Mapping, NamedTuple, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.model import Frame
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
        world = simulator.world
        if world.floor:
            self._add(FLOOR.name, world.floor, FLOOR.model.frames)
        for tree, body in zip(world.file.trees, world.bodies):
            self._add(tree.name.partition(LINK_SEPARATOR)[0], body, tree.model.frames)
        for vehicle in simulator.vehicles:
            # like Gazebo, without the links that are lumped into others
            self._add(vehicle.robot.name, vehicle.robot, {
                link: frame for link, frame in vehicle.model.frames.items()
                if link == frame.link})

    def _add(self, model: str, body: Body, frames: Mapping[str, Frame]) -> None:
        indices = link_indices(body.body_id, body.physics_client_id)
        for link, (part, pose) in frames.items():
            number = indices[part]
            self._links[model + LINK_SEPARATOR + link] = _Link(body, number,
                                                               body.in_part(number, pose))
        for joint, index in body.joints.items():
            self._joints[model + LINK_SEPARATOR + joint] = body, index

    def links(self) -> Dict[str, List[float]]:
        """Return x, y, z (m), a quaternion x, y, z, w, the velocity of the frame (m/s) and its
        angular velocity (rad/s) of each link, 13 numbers in the world.
        """
        return {name: list(_numbers(link.body.part_state(link.part, link.pose)))
                for name, link in self._links.items()}

    def joints(self) -> Dict[str, List[float]]:
        """Return position and velocity of each movable joint: rad and rad/s, or m and m/s."""
        return {name: list(pybullet.getJointState(body.body_id, index, **self._client)[:2])
                for name, (body, index) in self._joints.items()}

    def masses(self) -> Dict[str, List[float]]:
        """Return mass (kg) and moments of inertia about x, y and z of its axes through its center
        of mass (kg m2) of each link that PyBullet simulates.
        """
        found = {}
        for name, link in self._links.items():
            mass, _, moments, _, turned = pybullet.getDynamicsInfo(
                link.body.body_id, link.part, **self._client)[:5]
            turn = rotations.matrix(turned)
            found[name] = [mass, *np.diag(turn @ np.diag(moments) @ turn.T).tolist()]
        return found

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
