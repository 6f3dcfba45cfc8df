"""The models of a simulation by name, like Gazebo's: read, set, pushed, added and removed; and in
figures, as simulate.py prints them."""
import math
from typing import (Callable, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Sequence,
                    Tuple)

import numpy as np

from img_recog import rotations
from img_recog.errors import SimulationError, shortened
from img_recog.formats.sdf_models import BETWEEN_AXES
from img_recog.model import NO_INERTIA, Tree
from img_recog.rotations import IDENTITY, Quaternion, Transform
from img_recog.simulation.physics.body import (BodyPose, FrameState, Motion, motion_of_frame,
                                               relative, velocity_at)
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.model_bodies import ModelBodies
from img_recog.simulation.physics.pushes import Effort, Wrench
from img_recog.simulation.simulated_model import SimulatedModel
from img_recog.simulation.simulator import Simulator

WORLD = 'world'
LINK_SEPARATOR = '::'
# m, m/s, N: far beyond this PyBullet computes NaN, and the floor carries nothing from then on
_MAX_VALUE = 1e6


class State(NamedTuple):
    """Pose and velocity of a model or link in a reference frame: m, unit quaternion (x, y, z, w),
    m/s, rad/s.

    Like in Gazebo, a quaternion of zeros that is given is no rotation.
    """

    position: Sequence[float]
    orientation: Quaternion
    linear: Sequence[float]
    angular: Sequence[float]

    def pose(self) -> Transform:
        """Return the pose in the reference frame."""
        turn = self.orientation if np.linalg.norm(self.orientation) > 1e-6 else (0, 0, 0, 1)
        return Transform(rotations.matrix(turn), np.array(self.position, float))

    def check(self) -> None:
        """Raise SimulationError when a number is too large or not finite."""
        check('state', np.concatenate([np.array(part, float) for part in self]))


REST = State((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def in_world(motion: Motion) -> State:
    """Return the state in the world of what moves so."""
    turn = rotations.matrix(motion.orientation)
    return State(motion.position.tolist(), motion.orientation, turn @ motion.linear,
                 turn @ motion.angular)


def check(what: str, values: Sequence[float]) -> None:
    """Raise SimulationError, naming what they are, when numbers are too large or not finite."""
    given = np.array(values, float)
    if not np.all(np.isfinite(given)):
        raise SimulationError('{}: got {}, expected finite numbers'.format(what, given.tolist()))
    if np.abs(given).max(initial=0.0) > _MAX_VALUE:
        raise SimulationError('{0}: got {1}, expected numbers from -{2:g} to {2:g}'.format(
            what, given.tolist(), _MAX_VALUE))


class Models:
    """The models of a simulator: the floor, those of the world, the robots."""

    def __init__(self, simulator: Simulator):
        self._simulator, self._world = simulator, simulator.world

    def __contains__(self, name: str) -> bool:
        return name in self.names

    @property
    def names(self) -> List[str]:
        """The names of all models."""
        return [model.name for model in self._world.models]

    @property
    def bodies(self) -> Iterator[Tuple[str, FramedBody]]:
        """The bodies of all models, each with the name of its model."""
        return ((model.name, body) for model in self._world.models for body in model.bodies)

    def model(self, name: str) -> ModelBodies:
        """Return the model of a name; SimulationError when there is no such model."""
        for model in self._world.models:
            if model.name == name:
                return model
        raise SimulationError('no model {!r} (models: {})'.format(name, ', '.join(self.names)))

    def link(self, name: str) -> Tuple[FramedBody, str]:
        """Return the body and the link of the name MODEL::LINK or, like Gazebo, the first LINK.

        Raises SimulationError when there is no such link.
        """
        for found in self.links(name):
            return found
        model, _, link = name.partition(LINK_SEPARATOR)
        known = [each for body in self.model(model).bodies for each in body.link_names]
        raise SimulationError('model {} has no link {!r} (links: {})'.format(
            model, link, ', '.join(known)))

    def joint(self, name: str) -> Tuple[FramedBody, str]:
        """Return the first one that `joints` yields; SimulationError when there is none."""
        for found in self.joints(name):
            return found
        raise SimulationError('no movable joint {!r} (movable joints: {})'.format(name, shortened(
            ', '.join(model + LINK_SEPARATOR + joint for model, body in self.bodies
                      for joint in body.first_axes) or 'none')))

    def links(self, name: str) -> Iterator[Tuple[FramedBody, str]]:
        """Yield the body and the link for each one of the name MODEL::LINK or LINK."""
        # as in Gazebo, a name of a model means that
        return iter(()) if name in self else self._parts(
            name, lambda body: body.link_names)

    def joints(self, name: str) -> Iterator[Tuple[FramedBody, str]]:
        """Yield the body and the joint for each movable one of the name MODEL::JOINT or JOINT."""
        return self._parts(name, lambda body: body.first_axes)

    def _parts(self, name: str, parts_of: Callable[[FramedBody], Iterable[str]]
               ) -> Iterator[Tuple[FramedBody, str]]:
        return ((body, part) for model, body in self.bodies for part in parts_of(body)
                if name in (part, model + LINK_SEPARATOR + part))

    def set_joints(self, name: str, positions: Mapping[str, float]) -> None:
        """Put joints of a model at positions in rad or m, as far as their limits allow, at rest.

        Of a joint with several axes, it is the first one. Like in Gazebo, names that the model
        does not have are left out.
        Raises SimulationError when there is no such model, or a position is not finite.
        """
        check('joint_positions', list(positions.values()))
        model = self.model(name)
        for joint, position in positions.items():
            for body, found in self.joints(joint):
                if body in model.bodies:
                    lower, upper = body.limits(found)[:2]
                    body.set_joint(body.first_axes[found], min(max(position, lower), upper))
        self._world.notify_moved(model, model.bodies)

    def state(self, name: str, frame: str = WORLD) -> State:
        """Return the state of a model or link relative to `frame`: the world, a model or a link.

        Links: see `link`. Raises SimulationError when there is no such model, link or frame.
        """
        model, origin = self._state_in_world(name), self._frame(frame)
        position, orientation = relative(model.position, model.orientation, origin.position,
                                         origin.orientation)
        turn = rotations.matrix(origin.orientation).T
        return State(position, orientation,
                     turn @ np.subtract(model.linear, origin.linear),
                     turn @ np.subtract(model.angular, origin.angular))

    def set_state(self, name: str, state: State, frame: str = WORLD) -> None:
        """Move a model to `state`, given in `frame`; its joints stay as they are.

        name: also MODEL::LINK, of a link without a joint above it: it is moved with all that is
        joined to it, and the other links of the model stay.
        Velocities are relative to the world, along the axes of `frame`; a static model has none.
        Raises SimulationError when there is no such model or frame, the model is the floor, or the
        state has a number that is not finite.
        """
        (model, bodies, in_model), origin = self._target(name), self._frame(frame).pose()
        if self._world.floor in bodies:
            raise SimulationError('model {} cannot be moved'.format(name))
        state.check()
        _move(bodies, in_model, origin @ state.pose(), origin.rotation @ state.linear,
              origin.rotation @ state.angular)
        self._world.notify_moved(model, bodies)

    def add(self, name: str, trees: Sequence[Tree], state: State,
            frame: str = WORLD) -> SimulatedModel:
        """Add a model to the world, and return it.

        trees: of the model, as they are when its file is the world; state: that the world of the
        file has in `frame`.
        Raises SimulationError when there is no such frame, a model has that name, the state is not
        allowed, PyBullet cannot load the model or the next step would take too long.
        """
        if name in self:
            raise SimulationError('there is a model {} already'.format(name), 'give another name')
        pose = self.pose_in_world(state, frame)
        placed = [tree._replace(pose=pose @ tree.pose) for tree in trees]
        self._world.load(placed)
        model = self._simulator.models[-1]
        model.name = name
        return model

    def pose_in_world(self, state: State, frame: str) -> Transform:
        """Return the pose in the world that `state` has in a frame.

        Raises SimulationError when there is no such frame, or the state is not allowed.
        """
        origin = self._frame(frame).pose()
        state.check()
        return origin @ state.pose()

    def remove(self, name: str) -> SimulatedModel:
        """Remove a model from the world, and return it; SimulationError if it is the floor."""
        model = self.model(name)
        if not isinstance(model, SimulatedModel):       # the floor
            raise SimulationError('model {} cannot be deleted'.format(name))
        self._world.remove(model)
        return model

    def apply_wrench(self, link: str, force: Sequence[float], torque: Sequence[float],
                     start_s: float, duration_s: float, point: Sequence[float] = (0.0, 0.0, 0.0),
                     frame: str = WORLD) -> None:
        """Let a force (3,) in N and a torque (3,) in N m act on a link for a time.

        start_s: simulated, what has passed is now; duration_s: at least one step, below 0 until it
        is cleared, and with 0 nothing acts. A reset of the world clears all.
        They act at the center of mass, along the axes of the world, whatever the frame. In the
        frame of the world, the lever of the force is `point` (3,) in m. Any other is the name of a
        model or link: there, force, torque and point are given, and as gazebo_ros does it, they
        are seen from the link as it stands now; its axes then count as those of the world.
        Raises SimulationError when there is no such link or frame, or a number is not finite.
        """
        check('wrench', [*force, *torque, *point])
        body, name = self.link(link)
        act = np.array(force), np.array(torque) + np.cross(point, force)
        if frame != WORLD:
            seen = self.state(frame, link).pose()
            turned = seen.rotation @ act[0]
            act = turned, seen.rotation @ act[1] + np.cross(seen.translation, turned)
        wait, left = self._steps_of(start_s, duration_s)
        if left:
            self._world.pushes.add(Wrench(body, name, wait, left, *act))

    def apply_effort(self, joint: str, effort: float, start_s: float, duration_s: float) -> None:
        """Let a torque in N m or a force in N act on the first axis of a joint; times as for
        `apply_wrench`.

        Not more than the file gives as the limit of the effort, and not beyond that of the
        velocity. Raises SimulationError when there is no such joint that moves, or a number is not
        finite.
        """
        check('effort', [effort])
        body, name = self.joint(joint)
        limits = body.limits(name)
        wait, left = self._steps_of(start_s, duration_s)
        if left:
            within = min(max(effort, -limits.effort), limits.effort)
            self._world.pushes.add(Effort(body, name, wait, left, within, limits.velocity))

    def _steps_of(self, start_s: float, duration_s: float) -> Tuple[int, float]:
        """Return the steps until something begins, and those for which it acts."""
        step_s = self._world.step_s
        wait = max(0, round(start_s / step_s) - self._simulator.steps)
        if duration_s <= 0:
            return wait, math.inf if duration_s < 0 else 0
        return wait, max(1, round(duration_s / step_s))

    def clear_wrenches(self, link: str) -> None:
        """End those on MODEL::LINK, or on all links of a name.

        Like in Gazebo, nothing happens if there are none.
        """
        self._clear(Wrench, list(self.links(link)))

    def clear_efforts(self, joint: str) -> None:
        """End those of MODEL::JOINT, or of all joints of a name; as for `clear_wrenches`."""
        self._clear(Effort, list(self.joints(joint)))

    def _clear(self, kind: type, targets: Sequence[Tuple[object, str]]) -> None:
        self._world.pushes.remove(lambda push: isinstance(push, kind)
                                  and (push.body, push.name) in targets)

    def _target(self, name: str) -> Tuple[ModelBodies, Sequence[FramedBody], Transform]:
        """Return a model, its bodies, or for MODEL::LINK the one of that root link, and the pose
        of the first root link in the frame that a state is of.
        """
        model_name, _, link = name.partition(LINK_SEPARATOR)
        if name in self:        # that of a file may have a ::
            model_name, link = name, ''
        model = self.model(model_name)
        if not link:
            return model, model.bodies, model.trees[0].in_model
        bodies = {body.root: body for body in model.bodies}
        if link not in bodies:
            raise SimulationError('model {} has no link {!r} without a joint above it (such '
                                  'links: {})'.format(model_name, link, ', '.join(bodies)))
        return model, [bodies[link]], IDENTITY

    def _frame(self, name: str) -> State:
        return REST if name == WORLD else self._state_in_world(name)

    def _state_in_world(self, name: str) -> State:
        if name in self:
            model = self.model(name)
            return in_world(_motion(model.bodies[0], model.trees[0].in_model))
        body, link = self.link(name)
        return in_world(body.motion(link))


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


def _motion(body: FramedBody, in_model: Transform) -> Motion:
    """Return the motion of the frame in which the root link of a body has the pose `in_model`."""
    root = body.motion()
    turn = rotations.matrix(root.orientation)
    pose = Transform(turn, root.position) @ in_model.inverse
    return motion_of_frame(
        (pose.translation.tolist(), rotations.quaternion_of(pose.rotation)),
        root.position.tolist(), (turn @ root.linear).tolist(), (turn @ root.angular).tolist())


def _move(bodies: Sequence[FramedBody], in_model: Transform, pose: Transform, linear: np.ndarray,
          angular: np.ndarray) -> None:
    """Move bodies rigidly.

    Args:
        bodies: Bodies.
        in_model: Pose of the first root link in the frame that is moved to `pose`.
        pose: Pose of that frame in the world.
        linear: Velocity (3,) of that frame in m/s, along the axes of the world.
        angular: Angular velocity (3,) in rad/s, along the axes of the world.
    """
    motion = _motion(bodies[0], in_model)
    now = Transform(rotations.matrix(motion.orientation), motion.position)
    for body in bodies:
        old = body.pose()
        new = pose @ now.inverse @ Transform(rotations.matrix(old.orientation),
                                             np.array(old.position))
        body.place(BodyPose(new.translation.tolist(), rotations.quaternion_of(new.rotation),
                            old.joints))
        if not body.fixed:
            arm = new.translation - pose.translation
            body.set_velocity((linear + np.cross(angular, arm)).tolist(), angular.tolist())
