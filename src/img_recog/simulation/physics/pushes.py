"""Forces from outside that act on links and joints for a time, as those of gazebo_ros do."""
from dataclasses import dataclass
from typing import Callable, Container, Dict, Hashable, List

import numpy as np
import pybullet

from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.framed_body import FramedBody


@dataclass(eq=False)
class Push:
    """What acts in some steps. name: of the link or joint; wait: the steps until it begins;
    left: those in which it acts then, infinity until it is removed.
    """

    body: FramedBody
    name: str
    wait: int
    left: float

    @property
    def target(self) -> Hashable:
        """Of what has the same one, only the last one acts."""
        return self

    def apply(self) -> None:
        """Act in the next step."""
        raise NotImplementedError


@dataclass(eq=False)
class Wrench(Push):
    """A force (3,) in N at the center of mass of a link and a torque (3,) in N m, in the world."""

    force: np.ndarray
    torque: np.ndarray

    @property
    def target(self) -> Hashable:
        """As in Gazebo, the last wrench on a link replaces the others."""
        return self.body.body_id, self.name

    def apply(self) -> None:
        """Act in the next step."""
        self.body.push(self.name, self.force.tolist(), self.torque.tolist())


@dataclass(eq=False)
class Effort(Push):
    """A torque in N m or a force in N of a joint.

    As in Gazebo, those of one joint add up, and each is 0 while the joint is faster in its
    direction than highest_velocity, in rad/s or m/s.
    """

    effort: float
    highest_velocity: float

    def apply(self) -> None:
        """Act in the next step."""
        body, joint = self.body, self.body.first_axes[self.name]
        _, velocity = body.joint_state(joint)
        if velocity * np.sign(self.effort) <= self.highest_velocity:
            pybullet.setJointMotorControl2(
                body.body_id, body.joints[joint], pybullet.TORQUE_CONTROL, force=self.effort,
                **body.client)


class Pushes:
    """All that act or will act; true if there are any."""

    def __init__(self) -> None:
        self._pushes: List[Push] = []

    def __bool__(self) -> bool:
        return bool(self._pushes)

    @property
    def bodies(self) -> List[int]:
        """PyBullet's numbers of the bodies that they act on."""
        return [push.body.body_id for push in self._pushes]

    def add(self, push: Push) -> None:
        """Let it act, from the next step on or when it has waited."""
        self._pushes.append(push)

    def delay(self, bodies: Container[int]) -> None:
        """Let those on some bodies, by PyBullet's numbers, begin one step later."""
        for push in self._pushes:
            push.wait += push.body.body_id in bodies

    def apply(self) -> None:
        """Let them act in the next step."""
        acting: Dict[Hashable, Push] = {}
        for push in self._pushes:
            if push.wait > 0:
                push.wait -= 1
            else:
                push.left -= 1
                acting[push.target] = push
        for push in acting.values():
            push.apply()
        self.remove(lambda push: push.left <= 0)

    def remove(self, is_meant: Callable[[Push], bool]) -> None:
        """Remove those that are meant."""
        self._pushes = [push for push in self._pushes if not is_meant(push)]

    def forget(self, body: Body) -> None:
        """Remove those on a body."""
        self.remove(lambda push: push.body is body)

    def clear(self) -> None:
        """Remove all."""
        self._pushes = []
