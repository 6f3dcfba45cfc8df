"""The models of a simulation by name, like Gazebo's: read, set, added and removed."""
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.model import Tree
from img_recog.rotations import IDENTITY, Quaternion, Transform
from img_recog.simulation.physics.body import Body, Motion, Pose, motion_of_frame
from img_recog.simulation.physics.world import FLOOR
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

WORLD = 'world'
LINK_SEPARATOR = '::'
# m, m/s: far beyond this PyBullet computes NaN, and the floor carries nothing from then on
_MAX_VALUE = 1e6


class State(NamedTuple):
    """Pose and velocity of a model in a reference frame: m, unit quaternion (x, y, z, w), m/s,
    rad/s.

    Like in Gazebo, a quaternion of zeros that is given is no rotation.
    """

    position: Sequence[float]
    orientation: Quaternion
    linear: Sequence[float]
    angular: Sequence[float]


_REST = State((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class _Model:
    """The bodies of a model; its frame is fixed to the root link of the first one."""

    def __init__(self, bodies: List[Body], root: Transform = IDENTITY,
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
            body.place(Pose(new.translation.tolist(), rotations.quaternion_of(new.rotation),
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

    def state(self, name: str, frame: str = WORLD) -> State:
        """Return the state of a model relative to `frame`, the world or another model.

        Raises SimulationError when there is no such model or frame.
        """
        model, origin = self._state_in_world(name), self._frame(frame)
        back = pybullet.invertTransform(origin.position, origin.orientation)
        position, orientation = pybullet.multiplyTransforms(*back, model.position,
                                                            model.orientation)
        turn = rotations.matrix(back[1])
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
        model, origin = self._model(name), _transform(self._frame(frame))
        if name.partition(LINK_SEPARATOR)[0] == self._floor:
            raise SimulationError('model {} cannot be moved'.format(name))
        _check(state)
        model.place(origin @ _transform(state), origin.rotation @ state.linear,
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
        origin = _transform(self._frame(frame))
        _check(state)
        return origin @ _transform(state)

    def remove(self, name: str) -> None:
        """Remove a model from the world; SimulationError if it is the floor or a robot."""
        model = self._model(name)
        if name == self._floor or model.vehicle is not None:
            raise SimulationError('model {} cannot be deleted'.format(name))
        self._simulator.remove_bodies(model.bodies)
        del self._models[name]

    def _model(self, name: str) -> _Model:
        """Return a model, or of MODEL::LINK what is joined to that link."""
        model_name, _, link = name.partition(LINK_SEPARATOR)
        if name in self._models:        # that of a file may have a ::
            model_name, link = name, ''
        if model_name not in self._models:
            raise SimulationError('no model {!r} (models: {})'.format(
                model_name, ', '.join(self.names)))
        model = self._models[model_name]
        if not link:
            return model
        links = {body.root: body for body in model.bodies}
        if link not in links:
            raise SimulationError('model {} has no link {!r} without a joint above it (such '
                                  'links: {})'.format(model_name, link, ', '.join(links)))
        return _Model([links[link]], vehicle=model.vehicle)

    def _frame(self, name: str) -> State:
        return _REST if name == WORLD else self._state_in_world(name)

    def _state_in_world(self, name: str) -> State:
        motion = self._model(name).motion()
        turn = rotations.matrix(motion.orientation)
        return State(motion.position.tolist(), motion.orientation, turn @ motion.linear,
                     turn @ motion.angular)


def _grouped(trees: Sequence[Tree], bodies: Sequence[Body]) -> List[_Model]:
    """Return the models of trees that were loaded as bodies."""
    models: List[_Model] = []
    for tree, body in zip(trees, bodies):
        if tree.first:
            models.append(_Model([body], tree.in_model))
        else:
            models[-1].bodies.append(body)
    return models


def _transform(state: State) -> Transform:
    turn = state.orientation if np.linalg.norm(state.orientation) > 1e-6 else (0, 0, 0, 1)
    return Transform(rotations.matrix(turn), np.array(state.position, float))


def _check(state: State) -> None:
    values = np.concatenate([np.array(part, float) for part in state])
    if not np.all(np.isfinite(values)):
        raise SimulationError('state: got {}, expected finite numbers'.format(values.tolist()))
    if np.abs(values).max() > _MAX_VALUE:
        raise SimulationError('state: got {0}, expected numbers from -{1:g} to {1:g}'.format(
            values.tolist(), _MAX_VALUE))
