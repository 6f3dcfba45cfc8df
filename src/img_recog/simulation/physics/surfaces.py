"""Surfaces of links: the only module that gives PyBullet their friction, springs and filters.

    PyBullet gets                 at first                          changes
    lateralFriction               the file's; at most 1 if fixed    with what supports the link
    anisotropicFriction           the file's, along the link's axes of treads, with their heading
    contactStiffness and Damping  by springs.py                     never
    contactProcessingThreshold    0 for the contacts of ODE         while a robot falls
    restitution                   by springs.py                     never
    groups and mask               by collision_filters.py           never

ODE uses the lower coefficient of two surfaces; PyBullet multiplies them. So a fixed link has at
most 1, and a moving link has its own coefficient: the product is the lower one if at most one of
them is not 1. Where other surfaces can touch, the contacts are checked now and then, and a moving
link gets the coefficient with which the product is right.

Friction in ODE is a pyramid: the coefficient holds along each of two directions separately.
Without it, PyBullet weighs them by the mass that moves along each, and a skid-steered robot does
not turn. `mu2` scales one of them, along the nearest axis of the link.

If the file of a wheel has a direction of friction, the pyramid of ODE turns with the wheel. The
pyramid of PyBullet stays along the axes of the world. PyBullet can scale friction along the axes
of a link, and with a scale of 0 along one of them, both sides of the pyramid become the same. So
two links with the same treads share the load: one has friction around the wheel, the other one
along its axle.
"""
import itertools
import math
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.model import FLOOR_FRICTION, Friction, Joint
from img_recog.simulation.physics import collision_filters, springs
from img_recog.simulation.physics.body import Body, Vector
from img_recog.simulation.physics.client import client_argument
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tires import ACROSS, wheel_of

_EPSILON = 1e-6
_FALLS_M_S = 0.1        # vertical speed from which on a body falls
_ALWAYS_M = 1e18        # threshold with which all contacts that are computed act

_PARALLEL = 0.7
# A faster wheel turns too far between two updates. The mean over a turn is used.
_FAST_RAD_S, _MEAN_COSINE = 30.0, 2 / math.pi
_SLIPS_M_S = 0.01       # a contact of ODE pushes a wheel out with this speed, so less is no slip
_MAX_LOAD = 20.0        # ODE has no limit: the wheel jams

_Link = Tuple[int, int]         # PyBullet's numbers of a body and of a link of it


class _Coefficient(NamedTuple):
    """Coefficient of friction of a link.

    Attributes:
        given: Coefficient in the file.
        fixed: Whether the link never moves.
        start: Coefficient that PyBullet gets at first.
    """

    given: float
    fixed: bool
    start: float


class _Wheel(NamedTuple):
    """A wheel whose file gives a direction of friction.

    Attributes:
        body_id: PyBullet's number of the body.
        radius: Radius in m.
        mu: Coefficient of friction along the direction.
        axle: Unit vector (3,), in the frame of the center of mass of each tread.
        turning: Direction of friction (3,) in that frame if it turns with the wheel, with its
            length in the file.
        scales: Scales (3,) of friction along the axes of that frame, by the index of each tread.
    """

    body_id: int
    radius: float
    mu: float
    axle: Vector
    turning: Optional[Vector]
    scales: Dict[int, Vector]


class Surfaces:
    """Surfaces of all links in a physics client.

    PyBullet keeps the coefficient and the threshold with which a contact began. So the contacts
    of a link that gets others are made anew.

    Attributes:
        needs_updates: Whether `update` must be called every few steps.
    """

    def __init__(self, physics_client_id: int, step_s: float):
        self._client, self._step_s = client_argument(physics_client_id), step_s
        self._filters: Dict[_Link, Tuple[int, int]] = {}        # groups and mask
        self._apart: Set[collision_filters.Pair] = set()
        self._added: List[FramedBody] = []          # since the last `refresh`
        self._coefficients: Dict[_Link, _Coefficient] = {}
        self._changed: Dict[_Link, float] = {}
        self._products_differ = self.needs_updates = False
        self._wheels: List[_Wheel] = []
        # by PyBullet's number of the body: links whose contacts do not slow it down
        self._on_wheels: Dict[int, List[int]] = {}
        self._falling: Set[int] = set()

    @staticmethod
    def set_friction(body: FramedBody) -> None:
        """Give the links of a body the friction of its model, at the heading that it has now."""
        for link, (friction, never_moves) in _frictions(body).items():
            pybullet.changeDynamics(
                body.body_id, link, lateralFriction=friction.largest,
                anisotropicFriction=_scales(
                    body, link, friction.at_most(FLOOR_FRICTION) if never_moves else friction),
                **body.client)

    def add(self, bodies: Sequence[FramedBody], frozen: bool = False) -> None:
        """Add the bodies of a model.

        Args:
            bodies: Bodies.
            frozen: Whether nothing moves them.
        """
        for body in bodies:
            self.set_filters(body)
            self._added.append(body)
            if not frozen:
                self._set_springs(body)
                self._wheels += _wheels(body)
        for pair in collision_filters.apart(bodies):
            self.disable_collision(*pair)

    def _set_springs(self, body: FramedBody) -> None:
        found = springs.of_links(body)
        for link, spring in found.items():
            pybullet.changeDynamics(
                body.body_id, link, contactStiffness=spring.stiffness,
                contactDamping=spring.damping, **self._client,
                **({} if spring.slows else {'contactProcessingThreshold': 0}))
        for link, restitution in springs.restitutions(body).items():
            pybullet.changeDynamics(body.body_id, link, restitution=restitution, **self._client)
        links = [link for link, spring in found.items() if body.joints and not spring.slows]
        if links:
            self._on_wheels[body.body_id] = links

    def set_filters(self, body: FramedBody) -> None:
        """Set what the links of a body collide with.

        Rays and contacts then find a body that was moved while it slept.
        """
        for index, filters in collision_filters.of_links(body).items():
            self._filters[body.body_id, index] = filters
            self._forget_contacts((body.body_id, index))

    def disable_collision(self, body_a: int, body_b: int, link_a: int, link_b: int) -> None:
        """Let two links not collide until one of their bodies is removed."""
        pair = body_a, body_b, link_a, link_b
        pybullet.setCollisionFilterPair(*pair, 0, **self._client)
        self._apart.add(pair)

    def forget(self, body: Body) -> None:
        """Call before a body is removed: PyBullet gives its number to another one."""
        gone = {pair for pair in self._apart if body.body_id in pair[:2]}
        for pair in gone:
            pybullet.setCollisionFilterPair(*pair, 1, **self._client)
        self._apart -= gone
        self._added = [added for added in self._added if added is not body]
        self._wheels = [wheel for wheel in self._wheels if wheel.body_id != body.body_id]
        of_links: Sequence[Dict[_Link, Any]] = (self._filters, self._coefficients, self._changed)
        for known, link in itertools.product(of_links, body.links):
            known.pop((body.body_id, link), None)
        self._on_wheels.pop(body.body_id, None)
        self._falling.discard(body.body_id)

    def refresh(self) -> None:
        """Take note of bodies that were added or removed. Call it before the next step."""
        for body in self._added:
            for index, (friction, never_moves) in _frictions(body).items():
                link, given = (body.body_id, index), friction.largest
                start = min(given, FLOOR_FRICTION) if never_moves else given
                self._coefficients[link] = _Coefficient(given, never_moves, start)
                if start != given:
                    self._change(link, lateralFriction=start)
        self._added = []
        self._products_differ = _can_differ(self._coefficients)
        self.needs_updates = bool(self._products_differ or self._wheels or self._on_wheels)
        springs.set_up(self._client, self._step_s, bool(self._on_wheels))

    def forget_contacts(self) -> None:
        """Let the next step begin without contacts of an earlier one.

        PyBullet begins with their forces, which would make a difference after a reset. At first
        all links collide with nothing, so that nothing old is left among the new pairs. Then each
        link has a new number, and contacts are computed in the order of these numbers.
        """
        for link in self._filters:
            pybullet.setCollisionFilterGroupMask(*link, 0, 0, **self._client)
        for link in self._filters:
            self._forget_contacts(link)

    def _forget_contacts(self, link: _Link) -> None:
        """Let PyBullet make new contacts of a link. It does so when the mask of a link is set."""
        if link in self._filters:
            pybullet.setCollisionFilterGroupMask(*link, *self._filters[link], **self._client)

    def reset(self) -> None:
        """Begin at rest. Call it when everything was moved back to its start."""
        for link in self._changed:
            self._change(link, lateralFriction=self._coefficients[link].start)
        self._changed = {}
        for body_id in [*self._falling]:
            self._set_falling(body_id, False)

    def update(self) -> None:
        """Set what changes with the contacts and the motion of bodies. Call it every few steps."""
        if self._products_differ:
            self._update_coefficients()
        for wheel in self._wheels:
            factor = _factor(wheel, self._client)
            for link, scales in wheel.scales.items():
                pybullet.changeDynamics(wheel.body_id, link, anisotropicFriction=[
                    scale * factor for scale in scales], **self._client)
        for body_id in self._on_wheels:
            (_, _, up), _ = pybullet.getBaseVelocity(body_id, **self._client)
            falls = abs(up) > _FALLS_M_S
            if falls != (body_id in self._falling):
                self._set_falling(body_id, falls)

    def _set_falling(self, body_id: int, falls: bool) -> None:
        """Let a robot land without bouncing: contacts slow it down before it touches."""
        (self._falling.add if falls else self._falling.discard)(body_id)
        for link in self._on_wheels[body_id]:
            self._change((body_id, link), contactProcessingThreshold=falls * _ALWAYS_M)

    def _update_coefficients(self) -> None:
        """Give each link that moves the coefficient that is right with what supports it most."""
        forces: Dict[_Link, Dict[_Link, float]] = {}
        for contact in pybullet.getContactPoints(**self._client):
            ends = (contact[1], contact[3]), (contact[2], contact[4])
            for one, other in (ends, ends[::-1]):
                of_one = forces.setdefault(one, {})
                of_one[other] = of_one.get(other, 0.0) + contact[9]
        wanted: Dict[_Link, float] = {}
        for link in sorted(forces):
            if not self._coefficients[link].fixed:
                other = max(sorted(forces[link]), key=forces[link].__getitem__)
                value = self._value(link, other, wanted)
                if value != self._coefficients[link].start:
                    wanted[link] = value
        for link in {*wanted, *self._changed}:
            start = self._coefficients[link].start
            value = wanted.get(link, start)
            if value != self._changed.get(link, start):
                self._change(link, lateralFriction=value)
        self._changed = wanted

    def _value(self, link: _Link, other: _Link, wanted: Dict[_Link, float]) -> float:
        surface, against = self._coefficients[link], self._coefficients[other]
        of_other = wanted.get(other, against.start)
        lower = min(surface.given, against.given)
        if abs(surface.start * of_other - lower) < _EPSILON or not of_other:
            return surface.start
        return lower / of_other

    def _change(self, link: _Link, **values: float) -> None:
        pybullet.changeDynamics(*link, **values, **self._client)
        self._forget_contacts(link)


def _frictions(body: FramedBody) -> Dict[int, Tuple[Friction, bool]]:
    """Return the friction of each link, and whether it never moves, by PyBullet's indices."""
    given = {link.name: link.surface for link in body.model.links}
    static = body.static_links
    return {link: (Friction(0.0) if body.slides else given.get(wheel_of(name), Friction()),
                   link in static) for name, link in body.link_indices.items()}


def _can_differ(coefficients: Dict[_Link, _Coefficient]) -> bool:
    """Return whether two surfaces can touch whose product is not the lower one."""
    bodies: Dict[_Coefficient, Set[int]] = {}
    for (body, _), surface in coefficients.items():
        bodies.setdefault(surface, set()).add(body)
    return any(
        not (a.fixed and b.fixed) and len(bodies[a] | bodies[b]) > 1
        and abs(a.start * b.start - min(a.given, b.given)) > _EPSILON
        for a, b in itertools.combinations_with_replacement(bodies, 2))


def _scales(body: Body, link: int, friction: Friction) -> List[float]:
    """Return by what friction is scaled along the axes of a link's center of mass.

    Without a direction, mu holds along y of the world and mu2 along x, as on a floor in ODE.
    """
    if friction.mu == friction.across and not friction.direction:
        return [1.0, 1.0, 1.0]
    if friction.direction:
        to_center = rotations.matrix(
            pybullet.getDynamicsInfo(body.body_id, link, **body.client)[4]).T
        along, others = friction.mu, friction.across
        direction = to_center @ (
            np.array(friction.direction) / np.linalg.norm(friction.direction))
    else:
        along, others = friction.across, friction.mu
        direction = rotations.matrix(body.center(link)[1])[0]
    scales = np.full(3, others)
    scales[np.argmax(np.abs(direction))] = along
    return (scales / (friction.largest or 1.0)).tolist()


def _wheels(body: FramedBody) -> List[_Wheel]:
    """Return the wheels of a body that have a direction of friction."""
    surfaces = {link.name: link.surface for link in body.model.links}
    wheels = {wheel_of(name) for name in body.link_indices if name.endswith(ACROSS)}
    return [_wheel(body, joint, surfaces[joint.child])
            for joint in body.model.joints if joint.child in wheels]


def _wheel(body: FramedBody, joint: Joint, friction: Friction) -> _Wheel:
    direction, axle = np.array(friction.direction), np.asarray(joint.axis)
    length = np.linalg.norm(direction)
    treads = {name: index for name, index in body.link_indices.items()
              if name != joint.child and wheel_of(name) == joint.child}
    turn = rotations.matrix(pybullet.getDynamicsInfo(
        body.body_id, next(iter(treads.values())), **body.client)[4]).T
    is_axle = np.abs(turn @ axle) > _PARALLEL
    is_along_axle = abs(axle @ direction) > _PARALLEL * length
    # ODE takes the direction with its length, by which both forces grow
    coefficients = (length * np.array((friction.mu, friction.across)) if is_along_axle
                    else (friction.mu, friction.across))
    around, across = coefficients[::-1] if is_along_axle else coefficients
    half = 2 / (friction.largest or 1.0)        # each of two links has half of the load
    radius = max(pybullet.getCollisionShapeData(body.body_id, index, **body.client)[0][3][1]
                 for index in treads.values())
    return _Wheel(body.body_id, radius, friction.mu, (turn @ axle).tolist(),
                  None if is_along_axle else (turn @ direction).tolist(), {
                      index: (np.where(is_axle, across * half, 0.0) if name.endswith(ACROSS)
                              else np.where(is_axle, 0.0, around * half)).tolist()
                      for name, index in treads.items()})


def _factor(wheel: _Wheel, client: Dict[str, int]) -> float:
    """Return by what the friction of a wheel is scaled now."""
    # without numpy, which takes ten times as long for so little
    state = pybullet.getLinkState(wheel.body_id, next(iter(wheel.scales)), computeLinkVelocity=1,
                                  computeForwardKinematics=1, **client)
    (speed_x, speed_y, _), (turn_x, turn_y, _) = state[6:8]
    x, y, z, w = state[1]
    back = -x, -y, -z, w
    ((x, y, _),) = rotations.into_frame(back, wheel.axle)
    # the limits of both of PyBullet's directions add up
    factor = (math.hypot(x, y) or 1.0) / (abs(x) + abs(y) or 1.0)
    if wheel.turning is None:
        return factor
    # In ODE, the direction also points up and down while the wheel turns. Its horizontal part is
    # friction. Its vertical part is a load on the wheel, or lifts it.
    ((x, y, z),) = rotations.into_frame(back, wheel.turning)
    slip = x * (speed_x - turn_y * wheel.radius) + y * (speed_y + turn_x * wheel.radius)
    share = max(-1.0, min(slip / _SLIPS_M_S, 1.0))
    return factor * (_MEAN_COSINE * math.sqrt(x * x + y * y + z * z)
                     if math.hypot(turn_x, turn_y) > _FAST_RAD_S
                     else math.hypot(x, y) / max(1 - share * wheel.mu * z, 1 / _MAX_LOAD))
