"""The models of a simulation by name, like Gazebo's: read, set, added and removed."""
from typing import Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from img_recog import rotations
from img_recog.errors import SimulationError, shortened
from img_recog.model import Tree
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.physics.body import Motion, BodyPose, motion_of_frame, relative
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.world import FLOOR
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.states import REST, State, check, in_world
from img_recog.simulation.vehicle import Vehicle

WORLD = 'world'
LINK_SEPARATOR = '::'


class _Model:
    """The bodies of a model; its frame is fixed to the root link of the first one."""

    def __init__(self, bodies: List[FramedBody], root: Transform = IDENTITY,
                 vehicle: Optional[Vehicle] = None):
        """root: the pose of that root link in the frame of the model."""
        self.bodies, self.vehicle, self._root = bodies, vehicle, root

    def motion(self) -> Motion:
        """Return the motion of the frame of the model."""
        root = self.bodies[0].motion()
        turn = rotations.matrix(root.orientation)
        pose = Transform(turn, root.position) @ self._root.inverse
        return motion_of_frame(
            (pose.translation.tolist(), rotations.quaternion_of(pose.rotation)),
            root.position.tolist(), (turn @ root.linear).tolist(), (turn @ root.angular).tolist())

    def place(self, pose: Transform, linear: np.ndarray, angular: np.ndarray) -> None:
        """Move all bodies rigidly; pose, linear and angular: of the model in the world."""
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


class Models:
    """The models of a simulator: the floor, those of the world, the robots."""

    def __init__(self, simulator: Simulator):
        self._simulator, self._world = simulator, simulator.world
        world = simulator.world
        self._models: Dict[str, _Model] = {}
        self._floor = FLOOR.name if world.floor else ''
        if world.floor:
            self._models[FLOOR.name] = _Model([world.floor])
        for model in _grouped(world.file.trees, world.bodies):
            self._models[self._free_name(model.bodies[0].name)] = model
        for vehicle in simulator.vehicles:
            self.add_vehicle(vehicle)

    def add_vehicle(self, vehicle: Vehicle) -> None:
        """Make a robot a model, of the same name if that is free."""
        self._models[self._free_name(vehicle.robot.name)] = _Model([vehicle.robot],
                                                                   vehicle=vehicle)

    def remove_vehicle(self, vehicle: Vehicle) -> None:
        """Forget the model of a robot."""
        self._models = {name: model for name, model in self._models.items()
                        if model.vehicle is not vehicle}

    def vehicle(self, name: str) -> Optional[Vehicle]:
        """Return the robot that is the model of that name; None if there is none."""
        return self._models[name].vehicle if name in self._models else None

    def _free_name(self, name: str) -> str:
        number, free = 0, name
        while free in self._models:
            free, number = '{}_{}'.format(name, number), number + 1
        return free

    @property
    def names(self) -> List[str]:
        """The names of all models."""
        return list(self._models)

    @property
    def bodies(self) -> Iterator[Tuple[str, FramedBody]]:
        """The bodies of all models, each with the name of its model."""
        return ((name, body) for name, model in self._models.items() for body in model.bodies)

    def bodies_of(self, name: str) -> Sequence[FramedBody]:
        """Return the bodies of a model; SimulationError when there is no such model."""
        if name not in self._models:
            raise SimulationError('no model {!r} (models: {})'.format(name, ', '.join(self.names)))
        return self._models[name].bodies

    def link(self, name: str) -> Tuple[FramedBody, str]:
        """Return the body and the link of the name MODEL::LINK or, like Gazebo, the first LINK.

        Raises SimulationError when there is no such link.
        """
        for found in self.links(name):
            return found
        model, _, link = name.partition(LINK_SEPARATOR)
        known = [each for body in self.bodies_of(model) for each in body.link_names]
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
        return iter(()) if name in self._models else self._parts(
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
        bodies = self.bodies_of(name)
        for joint, position in positions.items():
            for body, found in self.joints(joint):
                if body in bodies:
                    lower, upper = body.limits(found)[:2]
                    body.set_joint(body.first_axes[found], min(max(position, lower), upper))
        self._simulator.notify_moved(bodies)

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
        model, origin = self._model(name), self._frame(frame).pose()
        if name.partition(LINK_SEPARATOR)[0] == self._floor:
            raise SimulationError('model {} cannot be moved'.format(name))
        state.check()
        model.place(origin @ state.pose(), origin.rotation @ state.linear,
                    origin.rotation @ state.angular)
        self._simulator.notify_moved(model.bodies)

    def add(self, name: str, trees: Sequence[Tree], state: State, frame: str = WORLD,
            warn: Callable[[str], None] = lambda line: None) -> None:
        """Add a model to the world.

        trees: of the model, as they are when its file is the world; state: that the world of the
        file has in `frame`; warn: gets a line if the next step takes long,
        and about what is simulated in another way than given.
        Raises SimulationError when there is no such frame, a model has that name, the state is not
        allowed, PyBullet cannot load the model or the next step would take too long.
        """
        if name in self._models:
            raise SimulationError('there is a model {} already'.format(name), 'give another name')
        pose = self.pose_in_world(state, frame)
        placed = [tree._replace(pose=pose @ tree.pose) for tree in trees]
        count = len(self._world.bodies)
        self._world.add(placed)
        if self._world.crowded:     # before that step, which holds all threads
            warn('model {}: {}'.format(name, self._world.crowded))
        for line in self._world.warnings:
            warn('model ' + line)
        self._models[name], = _grouped(placed, self._world.bodies[count:])

    def pose_in_world(self, state: State, frame: str = WORLD) -> Transform:
        """Return the pose in the world that `state` has in a frame.

        Raises SimulationError when there is no such frame, or the state is not allowed.
        """
        origin = self._frame(frame).pose()
        state.check()
        return origin @ state.pose()

    def remove(self, name: str) -> None:
        """Remove a model from the world; SimulationError if it is the floor or a robot."""
        bodies = self.bodies_of(name)
        if name == self._floor or self.vehicle(name) is not None:
            raise SimulationError('model {} cannot be deleted'.format(name))
        self._simulator.remove_bodies(bodies)
        del self._models[name]

    def _model(self, name: str) -> _Model:
        """Return a model, or of MODEL::LINK what is joined to that link."""
        model_name, _, link = name.partition(LINK_SEPARATOR)
        if name in self._models:        # that of a file may have a ::
            model_name, link = name, ''
        bodies = self.bodies_of(model_name)
        if not link:
            return self._models[model_name]
        links = {body.root: body for body in bodies}
        if link not in links:
            raise SimulationError('model {} has no link {!r} without a joint above it (such '
                                  'links: {})'.format(model_name, link, ', '.join(links)))
        return _Model([links[link]])

    def _frame(self, name: str) -> State:
        return REST if name == WORLD else self._state_in_world(name)

    def _state_in_world(self, name: str) -> State:
        if name in self._models:
            return in_world(self._models[name].motion())
        body, link = self.link(name)
        return in_world(body.motion(link))


def _grouped(trees: Sequence[Tree], bodies: Sequence[FramedBody]) -> List[_Model]:
    """Return the models of trees that were loaded as bodies."""
    models: List[_Model] = []
    for tree, body in zip(trees, bodies):
        if tree.first:
            models.append(_Model([body], tree.in_model))
        else:
            models[-1].bodies.append(body)
    return models
