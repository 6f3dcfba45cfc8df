"""Springs of contacts: how they give way, and with what restitution.

A contact of ODE pushes a body out of another one within one step. So a wheel leaves the floor by
some micrometers, falls back onto it, and touches it in every second to fifth step only. Friction
stops its edge in these steps, and between them it slips freely: a robot on many wheels turns as if
friction were viscous. PyBullet does the same if contacts act only where bodies touch, and without
its slop. So a robot on more than two wheels has the contacts of ODE, with half of their push: with
all of it, a robot that falls onto its wheels would bounce. Four or more light wheels lean instead,
and stay on the floor (tires.py, `leans`): they have springs like all others.

All other contacts are springs, with a stiffness for the mass of the body. The <kp>, <kd> and
<max_vel> of a file are used if they are softer.

ODE lets a body out of another one by <max_vel>, of which its velocity is told, and besides by all
of the spring, of which it is not told. With the default of 1 cm/s, contacts are dampers in which
the body goes down until what it is moved in a step is as much: that is a spring, too, which is the
softer the heavier the body is (`_as_moved`).
"""
import math
from typing import Dict, Iterable, List, Mapping, NamedTuple, Set, Tuple

import numpy as np
import pybullet

from img_recog.errors import SimulationError
from img_recog.model import BOX, CAPSULE, CYLINDER, MESH, SPHERE, Contact, Solid
from img_recog.rotations import IDENTITY, matrix
from img_recog.simulation.physics import mesh_cache
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tires import ACROSS, leans

# of a contact: so much damping that nothing vibrates, and what fell is out of the floor in 0.3 s
_STIFFNESS_N_M, _DAMPING_N_S_M = 3e5, 1e5
# for each kg of a body with joints that does not stand on wheels; no contact of a robot is softer
_JOINTED_N_M, _JOINTED_N_S_M = 1e4, 2e3
_SLOP_M = 1e-5          # PyBullet's default
_PUSH = 0.5         # share of the depth of a wheel that a contact pushes out in a step
# for each kg of a robot: two links that touch in one place share the load only if both give way
_SHARED_N_M = 1e6
# of what bounces: so much damping that only its coefficient throws it back. ODE takes the higher
# one of that and of the speed with which it lets out what is deep, which is more for little
_BOUNCING = 3e7, 1e7
_LITTLE = 0.5
_BOUNCES_FROM_M_S = 0.01
_BULLETS_DAMPING = 0.1      # of what has none of its own, such as a floor
_LOW_M, _RESTS_M = 0.01, 0.003


class Spring(NamedTuple):
    """The contacts of a link.

    Attributes:
        stiffness: In N/m.
        damping: In N s/m.
        slows: Whether PyBullet slows a body down before it touches, so that it never gets deep.
    """

    stiffness: float
    damping: float
    slows: bool = True


def set_up(client: Dict[str, int], step_s: float, on_wheels: bool) -> None:
    """Set how contacts are solved in a client.

    Args:
        client: Argument that names the client.
        step_s: Time of a step in s.
        on_wheels: Whether there is a robot on more than two wheels. The wheels would never leave
            the floor with PyBullet's slop.
    """
    total = step_s * _STIFFNESS_N_M + _DAMPING_N_S_M
    pybullet.setPhysicsEngineParameter(
        enableConeFriction=0, globalCFM=1 / total, contactERP=step_s * _STIFFNESS_N_M / total,
        restitutionVelocityThreshold=_BOUNCES_FROM_M_S,
        contactSlop=0 if on_wheels else _SLOP_M, **client)


def restitutions(body: FramedBody) -> Dict[int, float]:
    """Return the restitution of each link that bounces, by PyBullet's indices."""
    # PyBullet multiplies those of two bodies, where ODE takes the lower one
    return {link: math.sqrt(contact.bounce) for link, contact in _contacts(body).items()
            if contact.bounce > _LITTLE and (body.fixed or contact.throws)}


def of_links(body: FramedBody) -> Dict[int, Spring]:
    """Return the springs of the links of a body that have their own, by PyBullet's indices."""
    contacts = _contacts(body)
    mass = 0.0 if body.fixed else body.mass()
    if not mass:
        return {}
    has_contacts = any(contact != Contact() for contact in contacts.values())
    lows = _lows(body) if body.joints or has_contacts else []
    # links with treads in places where other links have theirs, too
    shared = {body.link_indices[name] for across in body.link_indices if across.endswith(ACROSS)
              for name in (across, across[:-len(ACROSS)])}
    found: Dict[int, Spring] = {}
    limit = _STIFFNESS_N_M
    if body.joints:
        limit = mass * _JOINTED_N_M
        found = {link: Spring(limit, mass * _JOINTED_N_S_M) for link in body.links}
        if _stands_on_wheels(lows):
            found.update(_of_robot(body, mass, contacts, shared))
    points = [low.points() for low in lows]
    count = sum(in_ode for in_ode, _ in points)
    for link, contact in contacts.items():
        if contact == Contact():
            continue
        spring = _as_moved(contact, mass, count, body)
        if spring.stiffness < limit:
            factor = count / sum(here for _, here in points) / (1 + (link in shared))
            found[link] = Spring(spring.stiffness * factor, spring.damping * factor)
        elif contact.throws and not body.joints:
            found[link] = (Spring(*_BOUNCING) if contact.bounce > _LITTLE
                           else spring)._replace(slows=False)
    return found


def _of_robot(body: FramedBody, mass: float, contacts: Mapping[int, Contact],
              shared: Set[int]) -> Dict[int, Spring]:
    """Return the springs of a body on wheels: the springs of ODE, with less push."""
    step_s = pybullet.getPhysicsEngineParameters(**body.client)['fixedTimeStep']
    found, names = {}, body.link_indices
    # a wheel itself meets no floor
    for link in contacts.keys() - {names[wheel] for wheel in body.with_treads}:
        contact = contacts[link]
        stiffness = (min(contact.stiffness / 2, _SHARED_N_M * mass) if link in shared
                     else contact.stiffness)
        damping = max(contact.damping, step_s * stiffness * (1 / _PUSH - 1))
        found[link] = Spring(stiffness, damping, slows=False)
    return found


def _as_moved(contact: Contact, mass: float, count: int, body: Body) -> Spring:
    """Return the spring for a body of a mass in kg that stands on a number of points.

    A velocity v in a contact of ODE, which pushes with D = h kp + kd, meets a force of
    D (max_vel - v). What h F / m does not take of the position in a step of h, the spring does.
    """
    values = pybullet.getPhysicsEngineParameters(**body.client)
    step_s = values['fixedTimeStep']
    load = mass * math.hypot(*(values['gravityAcceleration' + axis] for axis in 'XYZ'))
    # <kd> of both add up, and that of a floor is 1
    damping = max(contact.damping, 0.0) + Contact().damping
    pushing = step_s * contact.stiffness + damping
    sinks = load / (count * pushing) - contact.fastest
    if sinks <= 0 or not load:
        return Spring(contact.stiffness, damping - _BULLETS_DAMPING)
    stiffness = contact.stiffness * load / (load + mass * sinks / step_s)
    return Spring(stiffness, max(pushing + step_s * (contact.stiffness - stiffness)
                                 - _BULLETS_DAMPING, 0.0))


def _contacts(body: FramedBody) -> Dict[int, Contact]:
    return body.of_solids(lambda link: link.solids[0].contact)


class _Low(NamedTuple):
    """A solid on which a body can stand.

    Attributes:
        height_m: Height above the lowest solid of the body.
        solid: Its shape and pose in the link.
        is_wheel: Whether it is a wheel with treads that does not lean in ODE.
        turned: Its rotation (3, 3) in the world.
    """

    height_m: float
    solid: Solid
    is_wheel: bool
    turned: np.ndarray

    def points(self) -> Tuple[int, int]:
        """Return on how many points it touches a floor, in ODE and in PyBullet."""
        if self.solid.shape.kind == CYLINDER:
            return (4, 2) if abs(self.turned[2, 2]) > 0.5 else (2, 2)
        return (1, 1) if self.solid.shape.kind == SPHERE else (4, 4)


def _lows(body: FramedBody) -> List[_Low]:
    """Return the lowest solids of a body where it was loaded."""
    wheels = {link.name for link in body.loaded.links
              if link.name in body.with_treads and not leans(link, body.loaded)}
    found: List[_Low] = []
    for link in body.model.links:
        part = body.link_indices[link.name]
        position, orientation = body.part_state(part, body.in_part(part, IDENTITY)).frame
        turned = matrix(orientation)
        found += [_Low(position[2] + _lowest(solid, turned), solid, link.name in wheels,
                       turned @ solid.pose.rotation) for solid in link.solids]
    lowest = min((low.height_m for low in found), default=0.0)
    return [low._replace(height_m=low.height_m - lowest) for low in found
            if low.height_m - lowest < _LOW_M]


def _lowest(solid: Solid, turned: np.ndarray) -> float:
    """Return the lowest z of a solid, given the rotation (3, 3) of its link."""
    z, up = turned[2] @ solid.pose.translation, turned[2] @ solid.pose.rotation
    kind, size = solid.shape.kind, solid.shape.size
    if kind == MESH:
        try:
            path = mesh_cache.cached(solid.shape.path, solid.shape.submesh)
        except SimulationError:
            return math.inf     # left out
        bounds = np.multiply(mesh_cache.bounds(path), size)
        return float(z + up @ bounds.mean(axis=0) - np.abs(up * np.ptp(bounds, axis=0)).sum() / 2)
    if kind == BOX:
        return float(z - np.abs(up * size).sum() / 2)
    round_part = 1.0 if kind in (SPHERE, CAPSULE) else math.hypot(*up[:2])
    length = size[1] if kind in (CYLINDER, CAPSULE) else 0.0
    return float(z - size[0] * round_part - length * abs(up[2]) / 2)


def _stands_on_wheels(lows: Iterable[_Low]) -> bool:
    """Return whether a body stands on more than two wheels, and at most on one other solid.

    ODE's joints give way, so that wheels share the load with several casters. Those here do not,
    so such a body keeps contacts that give way.
    """
    are_wheels = [low.is_wheel for low in lows if low.height_m < _RESTS_M]
    return are_wheels.count(True) > 2 and are_wheels.count(False) <= 1
