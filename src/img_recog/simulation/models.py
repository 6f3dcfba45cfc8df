"""The bodies of a simulation by name, like Gazebo's models: their states, read and set."""
from typing import Dict, List, NamedTuple, Sequence

import numpy as np
import pybullet

from img_recog.simulation.body import Body, Pose, Quaternion, rotation_matrix
from img_recog.simulation.settings import SimulationError
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

WORLD = 'world'
# m, m/s: far beyond this PyBullet computes NaN, and the floor carries nothing from then on
_MAX_VALUE = 1e6


class State(NamedTuple):
    """Pose and velocity of a model in a reference frame: m, unit quaternion (x, y, z, w), m/s,
    rad/s.
    """

    position: Sequence[float]
    orientation: Quaternion
    linear: Sequence[float]
    angular: Sequence[float]


_REST = State((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class Models:
    """The models of a simulator: the floor, the bodies of the world, the robots."""

    def __init__(self, simulator: Simulator):
        self._bodies: Dict[str, Body] = {}
        self._vehicles: Dict[str, Vehicle] = {}
        for body in [simulator.world.floor, *simulator.world.bodies]:
            self._bodies[self._free_name(body.name)] = body
        for vehicle in simulator.vehicles:
            name = self._free_name(vehicle.robot.name)
            self._bodies[name], self._vehicles[name] = vehicle.robot, vehicle

    def _free_name(self, name: str) -> str:
        number, free = 0, name
        while free in self._bodies:
            free, number = '{}_{}'.format(name, number), number + 1
        return free

    @property
    def names(self) -> List[str]:
        """The names of all models."""
        return list(self._bodies)

    def state(self, name: str, frame: str = WORLD) -> State:
        """Return the state of a model relative to `frame`, the world or another model.

        Raises SimulationError when there is no such model or frame.
        """
        model, origin = self._state_in_world(name), self._frame(frame)
        back = pybullet.invertTransform(origin.position, origin.orientation)
        position, orientation = pybullet.multiplyTransforms(*back, model.position,
                                                            model.orientation)
        turn = rotation_matrix(back[1])
        return State(position, orientation,
                     turn @ np.subtract(model.linear, origin.linear),
                     turn @ np.subtract(model.angular, origin.angular))

    def set_state(self, name: str, state: State, frame: str = WORLD) -> None:
        """Move a model to `state`, given in `frame`; its joints stay as they are.

        Velocities are relative to the world, along the axes of `frame`.
        Raises SimulationError when there is no such model or frame, the model is static, or the
        state has a number that is not finite or an orientation that is not a rotation.
        """
        body, origin = self._body(name), self._frame(frame)
        if body.mass() == 0 or body.fixed:
            raise SimulationError('model {} is static'.format(name))
        _check(state)
        norm = np.linalg.norm(state.orientation)
        position, orientation = pybullet.multiplyTransforms(
            origin.position, origin.orientation, state.position,
            (np.array(state.orientation) / norm).tolist())
        turn = rotation_matrix(origin.orientation)
        body.place(Pose(position, orientation, body.pose().joints))
        body.set_velocity((turn @ state.linear).tolist(), (turn @ state.angular).tolist())
        if name in self._vehicles:
            self._vehicles[name].notify_teleported()

    def _body(self, name: str) -> Body:
        if name not in self._bodies:
            raise SimulationError('no model {!r} (models: {})'.format(name, ', '.join(self.names)))
        return self._bodies[name]

    def _frame(self, name: str) -> State:
        return _REST if name == WORLD else self._state_in_world(name)

    def _state_in_world(self, name: str) -> State:
        motion = self._body(name).motion()
        turn = rotation_matrix(motion.orientation)
        return State(motion.position.tolist(), motion.orientation, turn @ motion.linear,
                     turn @ motion.angular)


def _check(state: State) -> None:
    values = np.concatenate([np.array(part, float) for part in state])
    if not np.all(np.isfinite(values)):
        raise SimulationError('state: got {}, expected finite numbers'.format(values.tolist()))
    if np.abs(values).max() > _MAX_VALUE:
        raise SimulationError('state: got {0}, expected numbers from -{1:g} to {1:g}'.format(
            values.tolist(), _MAX_VALUE))
    if np.linalg.norm(state.orientation) < 1e-6:
        raise SimulationError('state: got a zero quaternion as orientation, expected a rotation')
