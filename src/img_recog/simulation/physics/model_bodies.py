"""A model of the world as the physics has it."""
from typing import Sequence

import numpy as np

from img_recog import rotations
from img_recog.model import Tree
from img_recog.rotations import Transform
from img_recog.simulation.physics.body import BodyPose, Motion, motion_of_frame
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

    def part(self, body: FramedBody) -> 'ModelBodies':
        """Return one body of the model as a model whose frame is that of its root link."""
        return ModelBodies(self.name, [Tree(body.name, body.model)], [body])

    def motion(self) -> Motion:
        """Return the motion of the frame of the model."""
        root = self.bodies[0].motion()
        turn = rotations.matrix(root.orientation)
        pose = Transform(turn, root.position) @ self.trees[0].in_model.inverse
        return motion_of_frame(
            (pose.translation.tolist(), rotations.quaternion_of(pose.rotation)),
            root.position.tolist(), (turn @ root.linear).tolist(), (turn @ root.angular).tolist())

    def move(self, pose: Transform, linear: np.ndarray, angular: np.ndarray) -> None:
        """Move all bodies rigidly.

        Args:
            pose: Pose of the frame of the model in the world.
            linear: Velocity (3,) of that frame in m/s, along the axes of the world.
            angular: Angular velocity (3,) in rad/s, along the axes of the world.
        """
        motion = self.motion()
        now = Transform(rotations.matrix(motion.orientation), motion.position)
        for body in self.bodies:
            old = body.pose()
            new = pose @ now.inverse @ Transform(rotations.matrix(old.orientation),
                                                 np.array(old.position))
            body.place(BodyPose(new.translation.tolist(), rotations.quaternion_of(new.rotation),
                                old.joints))
            if not body.fixed:
                arm = new.translation - pose.translation
                body.set_velocity((linear + np.cross(angular, arm)).tolist(), angular.tolist())

    def reset(self) -> None:
        """Move all bodies back to where they were when they were added, at rest."""
        for body in self.bodies:
            body.reset()

    def notify_moved(self) -> None:
        """Call after the model was moved from outside."""

    def notify_loaded_again(self) -> None:
        """Call after PyBullet has loaded the bodies again."""
