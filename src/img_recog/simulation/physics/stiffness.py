"""How contacts give way, and what comes back from them.

What stands on more than three points has the same load on all, as ODE has it, only if the contacts
give way a little: all are springs, with a stiffness for the mass of the body if that is high. What
a file has of <kp>, <kd> and <max_vel> counts where it is softer.

ODE lets a body out of another one by <max_vel>, of which its velocity is told, and besides by all
of the spring, of which it is not told. With the default of 1 cm/s, contacts are dampers in which
the body goes down until what it is moved in a step is as much: that is a spring, too, which is the
softer the heavier the body is (`_as_moved`).
"""
import math
from typing import Dict, List, NamedTuple, Tuple

import pybullet

from img_recog.model import CYLINDER, SPHERE, Contact, Solid
from img_recog.rotations import matrix
from img_recog.simulation.physics.client import link_indices, links_of_base
from img_recog.simulation.physics.framed_body import FramedBody

# of a contact: so much damping that nothing vibrates, and what fell is out of the floor in 0.3 s
_STIFFNESS_N_M, _DAMPING_N_S_M = 3e5, 1e5
# for each kg of a body with joints: so low that its load is spread over its wheels
_JOINTED_N_M, _JOINTED_N_S_M = 1e4, 2e3
# of what bounces: so much damping that only its coefficient throws it back. ODE takes the higher
# one of that and of the speed with which it lets out what is deep, which is more for little
_BOUNCING = 3e7, 1e7
_LITTLE = 0.5
_BOUNCES_FROM_M_S = 0.01
_BULLETS_DAMPING = 0.1      # of what has none of its own, such as a floor
_LOW_M = 0.01


class Spring(NamedTuple):
    """Of the contacts of a link: N/m, N s/m."""

    stiffness: float
    damping: float

    def scaled(self, factor: float) -> 'Spring':
        """Return one that gives way as much under `factor` times the load."""
        return Spring(self.stiffness * factor, self.damping * factor)


def set_up(physics_client_id: int, step_s: float) -> None:
    """Set how contacts are solved in a client without bodies."""
    total = step_s * _STIFFNESS_N_M + _DAMPING_N_S_M
    pybullet.setPhysicsEngineParameter(
        enableConeFriction=0, globalCFM=1 / total, contactERP=step_s * _STIFFNESS_N_M / total,
        restitutionVelocityThreshold=_BOUNCES_FROM_M_S, physicsClientId=physics_client_id)


def apply(body: FramedBody) -> None:
    """Give the contacts of a body their stiffness, and let it bounce if its file says so."""
    for link, spring in springs(body).items():
        set_spring(body, link, spring)
    for link, contact in _contacts(body).items():
        if contact.bounce > _LITTLE and (body.fixed or contact.throws):
            # PyBullet multiplies those of two bodies, where ODE takes the lower one
            pybullet.changeDynamics(body.body_id, link, restitution=math.sqrt(contact.bounce),
                                    physicsClientId=body.physics_client_id)
        if contact.throws and not body.fixed and not body.joints:
            # what does not touch yet is not slowed down
            pybullet.changeDynamics(body.body_id, link, contactProcessingThreshold=0,
                                    physicsClientId=body.physics_client_id)


def set_spring(body: FramedBody, link: int, spring: Spring) -> None:
    """Let the contacts of a link, by PyBullet's number, give way like a spring."""
    pybullet.changeDynamics(
        body.body_id, link, contactStiffness=spring.stiffness, contactDamping=spring.damping,
        physicsClientId=body.physics_client_id)


def springs(body: FramedBody) -> Dict[int, Spring]:
    """Return those of the links of a body, by PyBullet's numbers, that have one of their own."""
    found: Dict[int, Spring] = {}
    mass = 0.0 if body.fixed else body.mass()
    if not mass:
        return found
    contacts, limit = _contacts(body), _STIFFNESS_N_M
    if body.joints:
        limit = mass * _JOINTED_N_M
        found = {link: Spring(limit, mass * _JOINTED_N_S_M) for link in
                 link_indices(body.body_id, body.physics_client_id).values()}
    points = _points(body) if any(contact != Contact() for contact in contacts.values()) else []
    count = sum(in_ode for in_ode, _ in points)
    for link, contact in contacts.items():
        if contact == Contact():
            continue
        spring = _as_moved(contact, mass, count, body.physics_client_id)
        if spring.stiffness < limit:
            found[link] = spring.scaled(count / sum(here for _, here in points))
        elif contact.throws and not body.joints:
            found[link] = Spring(*_BOUNCING) if contact.bounce > _LITTLE else spring
    return found


def _as_moved(contact: Contact, mass: float, count: int, physics_client_id: int) -> Spring:
    """Return the spring for a body of a mass in kg that stands on a number of points.

    A velocity v in a contact of ODE, which pushes with D = h kp + kd, meets a force of
    D (max_vel - v). What h F / m does not take of the position in a step of h, the spring does.
    """
    values = pybullet.getPhysicsEngineParameters(physicsClientId=physics_client_id)
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
    """Return those of the links that have solids, by PyBullet's numbers."""
    indices = link_indices(body.body_id, body.physics_client_id)
    return {indices[link.name]: link.solids[0].contact for link in body.model.links
            if link.solids}


def _points(body: FramedBody) -> List[Tuple[int, int]]:
    """Return on how many points each solid that a body stands on where it was loaded touches a
    floor, in ODE and in PyBullet."""
    client = {'physicsClientId': body.physics_client_id}
    indices = link_indices(body.body_id, body.physics_client_id)
    lows = {link.name: pybullet.getAABB(body.body_id, indices[link.name], **client)[0][2]
            for link in body.model.links if link.solids}
    return [_of_solid(body, indices[link.name], solid) for link in body.model.links
            for solid in link.solids if lows[link.name] < min(lows.values()) + _LOW_M]


def _of_solid(body: FramedBody, link: int, solid: Solid) -> Tuple[int, int]:
    if solid.shape.kind == SPHERE:
        return 1, 1
    if solid.shape.kind == CYLINDER:
        client = {'physicsClientId': body.physics_client_id}
        turned = (pybullet.getBasePositionAndOrientation(body.body_id, **client)[1]
                  if link in links_of_base(body.body_id, body.physics_client_id) else
                  pybullet.getLinkState(body.body_id, link, **client)[5])
        stands = abs((matrix(turned) @ solid.pose.rotation)[2, 2]) > 0.5
        return (4, 2) if stands else (2, 2)
    return 4, 4
