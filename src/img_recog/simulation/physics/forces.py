"""Forces that Gazebo has and PyBullet has not: of springs, against gravity and of velocity decay.

They act in each step, on the bodies that have any. As in ODE, those of springs and dampers are
what the state before the step says. That is stable as long as they are small for the inertia that
they act on; those of a file that are not would throw the body to infinity, in Gazebo too.
"""
from typing import Dict, Iterator, List, Sequence, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.model import Joint
from img_recog.report import NOTE, Report
from img_recog.simulation.physics.body import Body, Vector
from img_recog.simulation.physics.framed_body import FramedBody

_MIN_SPEED = 0.01       # m/s and rad/s, of velocity decay: that of ODE
_STABLE = 1.9           # the limit is 2; of what is beyond it, _KEPT is simulated
_KEPT = 1.0
_MIN_MOBILITY = 1e-12


class Forces:
    """What acts on a body in each step of PyBullet.

    gravity: (3,) m/s2, in the world.
    """

    def __init__(self, body: FramedBody, step_s: float, gravity: Vector,
                 report: Report):
        """report: gets a line for each joint that is simulated with other values."""
        self._body, self._client = body, body.client
        self._step_s, self.gravity = step_s, gravity
        self._report = report
        stable = list(self._stable([
            joint for joint in body.model.joints
            if joint.name in body.joints and (joint.stiffness or joint.damping)]))
        self._springs = [(body.joints[joint.name], joint.stiffness, joint.reference)
                         for joint in stable if joint.stiffness]
        # mass, inertia and decay of links
        self._links: List[Tuple[int, float, np.ndarray, bool, Tuple[float, float]]] = []
        for link in body.model.links:
            index = body.link_indices[link.name]
            mass, _, moments = pybullet.getDynamicsInfo(body.body_id, index, **self._client)[:3]
            if mass and (link.has_gravity is False or any(link.decay)):
                self._links.append((index, mass, np.array(moments),
                                    link.has_gravity is False, link.decay))

    def __bool__(self) -> bool:
        return bool(self._springs or self._links)

    def _stable(self, joints: Sequence[Joint]) -> Iterator[Joint]:
        """Yield joints with dampings and stiffnesses that are stable, and set these dampings."""
        inertias = _inertias(self._body) if joints else {}
        for joint in joints:
            index = self._body.joints[joint.name]
            highest = (_KEPT * inertias[index] / self._step_s,
                       _KEPT * inertias[index] / self._step_s ** 2)
            if joint.damping / highest[0] + joint.stiffness / highest[1] / 2 > _STABLE:
                kept = min(joint.damping, highest[0]), min(joint.stiffness, highest[1])
                self._report.add(
                    NOTE, 'joint {}: damping {:g} and stiffness {:g} cannot be simulated in steps '
                    'of {:g} s; it has {:g} and {:g}'.format(
                        joint.name, joint.damping, joint.stiffness, self._step_s, *kept))
                joint = joint._replace(damping=kept[0], stiffness=kept[1])
                pybullet.changeDynamics(self._body.body_id, index, jointDamping=kept[0],
                                        **self._client)
            yield joint

    def apply(self) -> None:
        """Let them act in the next step."""
        body_id, client = self._body.body_id, self._client
        if self._springs:
            indices = [index for index, _, _ in self._springs]
            states = pybullet.getJointStates(body_id, indices, **client)
            torques = [stiffness * (reference - state[0])
                       for (_, stiffness, reference), state in zip(self._springs, states)]
            pybullet.setJointMotorControlArray(body_id, indices, pybullet.TORQUE_CONTROL,
                                               forces=torques, **client)
        for index, mass, moments, floats, decay in self._links:
            center, turned = self._body.center(index)
            linear, angular = map(np.array, self._body.velocity(index))
            force = -mass * np.array(self.gravity) if floats else np.zeros(3)
            if decay[0] and np.linalg.norm(linear) > _MIN_SPEED:
                force = force - mass * decay[0] / self._step_s * linear
            pybullet.applyExternalForce(body_id, index, force.tolist(), center,
                                        pybullet.WORLD_FRAME, **client)
            if decay[1] and np.linalg.norm(angular) > _MIN_SPEED:
                turn = rotations.matrix(turned)
                torque = -decay[1] / self._step_s * turn @ (moments * (turn.T @ angular))
                pybullet.applyExternalTorque(body_id, index, torque.tolist(),
                                             pybullet.WORLD_FRAME, **client)


def _inertias(body: Body) -> Dict[int, float]:
    """Return the inertia that a torque or force of each movable joint moves: kg m2 or kg."""
    positions = [state[0] for state in body.joint_values()]
    matrix = np.array(pybullet.calculateMassMatrix(body.body_id, positions, **body.client))
    # the first ones are those of a base that moves
    mobilities = np.linalg.pinv(matrix).diagonal()[-len(positions):]
    return {link: 1 / max(float(mobility), _MIN_MOBILITY)
            for link, mobility in zip(body.joints.values(), mobilities)}
