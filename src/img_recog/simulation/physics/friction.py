"""Contacts and friction like ODE's, with which Gazebo simulates.

Of two surfaces, ODE takes the lower coefficient; PyBullet multiplies them. So what never moves has
at most 1, and what moves its own coefficient: their product is the lower of the two wherever no
more than one is below 1 or above. Where others can meet, those that do are looked at now and then,
and what moves gets the coefficient that makes the product right with what bears it.

ODE's friction is a pyramid: the coefficient holds along each of two directions by itself. Without
that, PyBullet weighs them by the mass that moves along each, and a skid-steered robot does not
turn. `mu2` scales one of them, along an axis of the link that is nearest to it; of wheels see
directions.py.
"""
import itertools
from typing import Callable, Dict, List, NamedTuple, Set, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.model import FLOOR_FRICTION, Friction
from img_recog.simulation.physics import tires
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import body_ids, client_argument, links_of_base
from img_recog.simulation.physics.framed_body import FramedBody

_EPSILON = 1e-6

_Link = Tuple[int, int]         # PyBullet's numbers of a body and of a link of it


def set_dynamics(body: FramedBody) -> None:
    """Give the links of a body the friction of its model, and release its joints."""
    given = {link.name: link.surface for link in body.model.links}
    never_move = links_of_base(body.body_id, body.physics_client_id) if body.fixed else ()
    for name, link in body.link_indices.items():
        wheel = tires.wheel_of(name)
        friction = Friction(0.0) if body.slides else given.get(wheel, Friction())
        pybullet.changeDynamics(
            body.body_id, link, lateralFriction=friction.largest,
            anisotropicFriction=_scales(
                body, link, friction.at_most(FLOOR_FRICTION) if link in never_move
                else friction), **body.client)
    body.release(body.model.joints, body.driven)


def _scales(body: Body, link: int, friction: Friction) -> List[float]:
    """Return by what friction is scaled along the axes of a link's center of mass.

    Without a direction, mu holds along y of the world and mu2 along x, as on a floor in ODE, at
    the heading with which the body was loaded.
    """
    if friction.mu == friction.across and not friction.direction:
        return [1.0, 1.0, 1.0]
    if not friction.direction:
        scales = np.full(3, friction.mu)
        scales[np.argmax(np.abs(rotations.matrix(body.center(link)[1])[0]))] = friction.across
        return (scales / (friction.largest or 1.0)).tolist()
    to_center = rotations.matrix(pybullet.getDynamicsInfo(body.body_id, link, **body.client)[4]).T
    direction = np.array(friction.direction) / np.linalg.norm(friction.direction)
    scales = np.full(3, friction.across)
    scales[np.argmax(np.abs(to_center @ direction))] = friction.mu
    return (scales / (friction.largest or 1.0)).tolist()


class _Surface(NamedTuple):
    """Its coefficient in the file, whether it never moves, and the coefficient it starts with."""

    friction: float
    fixed: bool
    start: float


class Pairs:
    """The surfaces in a client, some of which need another coefficient where they touch.

    A contact in PyBullet keeps the coefficient that it began with, so the contacts of a link that
    gets another coefficient are made anew.
    """

    def __init__(self, physics_client_id: int, forget_contacts: Callable[[_Link], None]):
        self._client = client_argument(physics_client_id)
        self._forget_contacts = forget_contacts
        self._surfaces: Dict[_Link, _Surface] = {}
        self._changed: Dict[_Link, float] = {}

    def refresh(self) -> None:
        """Look for bodies that were added or removed."""
        before, self._surfaces = self._surfaces, {}
        for body in body_ids(self._client['physicsClientId']):
            fixed = pybullet.getDynamicsInfo(body, -1, **self._client)[0] == 0
            of_base = links_of_base(body, self._client['physicsClientId'])
            for link in range(-1, pybullet.getNumJoints(body, **self._client)):
                found = before.get((body, link))
                if found is None:
                    friction = pybullet.getDynamicsInfo(body, link, **self._client)[1]
                    never_moves = fixed and link in of_base
                    found = _Surface(friction, never_moves, min(friction, FLOOR_FRICTION)
                                     if never_moves else friction)
                    if found.start != friction:
                        self._set((body, link), found.start)
                self._surfaces[body, link] = found
        self._changed = {link: value for link, value in self._changed.items()
                         if link in self._surfaces}
        self.needs_updates = self._can_differ()

    def _can_differ(self) -> bool:
        """Return whether two surfaces can meet of which the product is not the lower one."""
        bodies: Dict[_Surface, Set[int]] = {}
        for (body, _), surface in self._surfaces.items():
            bodies.setdefault(surface, set()).add(body)
        return any(
            not (a.fixed and b.fixed) and len(bodies[a] | bodies[b]) > 1
            and abs(a.start * b.start - min(a.friction, b.friction)) > _EPSILON
            for a, b in itertools.combinations_with_replacement(bodies, 2))

    def reset(self) -> None:
        """Forget what touched: to be called when everything was moved back to its start."""
        for link in self._changed:
            self._set(link, self._surfaces[link].start)
        self._changed = {}

    def update(self) -> None:
        """Give each surface that moves the coefficient that is right with what supports it most.

        Call it every few steps, if `needs_updates`.
        """
        forces: Dict[_Link, Dict[_Link, float]] = {}
        for contact in pybullet.getContactPoints(**self._client):
            ends = (contact[1], contact[3]), (contact[2], contact[4])
            for one, other in (ends, ends[::-1]):
                of_one = forces.setdefault(one, {})
                of_one[other] = of_one.get(other, 0.0) + contact[9]
        wanted: Dict[_Link, float] = {}
        for link in sorted(forces):
            if not self._surfaces[link].fixed:
                other = max(sorted(forces[link]), key=forces[link].__getitem__)
                value = self._value(link, other, wanted)
                if value != self._surfaces[link].start:
                    wanted[link] = value
        for link in {*wanted, *self._changed}:
            value = wanted.get(link, self._surfaces[link].start)
            if value != self._changed.get(link, self._surfaces[link].start):
                self._set(link, value)
        self._changed = wanted

    def _value(self, link: _Link, other: _Link, wanted: Dict[_Link, float]) -> float:
        surface, against = self._surfaces[link], self._surfaces[other]
        of_other = wanted.get(other, against.start)
        lower = min(surface.friction, against.friction)
        if abs(surface.start * of_other - lower) < _EPSILON or not of_other:
            return surface.start
        return lower / of_other

    def _set(self, link: _Link, value: float) -> None:
        pybullet.changeDynamics(*link, lateralFriction=value, **self._client)
        self._forget_contacts(link)
