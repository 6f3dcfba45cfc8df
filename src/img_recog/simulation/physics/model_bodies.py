"""A model of the world as the physics has it."""
from typing import Sequence

from img_recog.model import Tree
from img_recog.simulation.physics.framed_body import FramedBody


class ModelBodies:
    """The bodies of a model in PyBullet.

    The frame of the model is fixed to the root link of the first body.

    Attributes:
        name: Name of the model, which no other model of the world has.
        trees: Trees of links that the bodies were made from.
        bodies: Body of each tree.
        is_robot: Whether the model is a robot, which outlines of the world leave out.
    """

    is_robot = False

    def __init__(self, name: str, trees: Sequence[Tree], bodies: Sequence[FramedBody]):
        self.name, self.trees, self.bodies = name, list(trees), list(bodies)

    def reset(self) -> None:
        """Move all bodies back to where they were when they were added, at rest."""
        for body in self.bodies:
            body.reset()

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        """Call after bodies of the model were moved from outside."""

    def notify_loaded_again(self) -> None:
        """Call after PyBullet has loaded the bodies again."""
