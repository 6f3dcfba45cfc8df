"""Which links meet, as in Gazebo: by bitmasks, and those of a model that it lets collide."""
import itertools
from typing import Dict, Iterator, Sequence, Set, Tuple

import pybullet

from img_recog.model import ALL_BITS, Model
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import link_indices, links_of_base
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tyres import ACROSS

# Two links meet in PyBullet if a group of one is in the mask of the other. Of those without a
# bitmask, all are, and so is the one that rays are in; those of a file are beyond its own. Links
# of what never moves are in one that does not meet itself, as PyBullet has it for a base.
_RAYS, _STATIC, _SHIFT = 1, 2, 8

_Pair = Tuple[int, int, int, int]        # two bodies, and a link of each


def has_spaces(model: Model) -> bool:
    """Return whether some links of a model meet one another."""
    return len({link.space for link in model.links if link.solids}) > 1


def groups_and_mask(bitmask: int) -> Tuple[int, int]:
    """Return in which groups of PyBullet what has a bitmask is, and which ones it meets."""
    if bitmask == ALL_BITS:
        return _RAYS, -1
    groups = bitmask << _SHIFT
    return groups, groups and groups | _RAYS


class Meeting:
    """What the links of bodies in a physics client meet."""

    def __init__(self, physics_client_id: int):
        self._client = {'physicsClientId': physics_client_id}
        self._apart: Set[_Pair] = set()
        # groups and mask of each link with solids
        self._masks: Dict[Tuple[int, int], Tuple[int, int]] = {}

    def add(self, bodies: Sequence[FramedBody]) -> None:
        """Add the bodies of a model."""
        for body in bodies:
            self.set_masks(body)
            if has_spaces(body.model):
                self._keep_apart(body, body)
        for one, other in itertools.combinations(bodies, 2):
            if not (one.fixed and other.fixed):
                self._keep_apart(one, other)

    def part(self, one: Body, link: int, other: Body, other_link: int) -> None:
        """Let two links not meet until one of their bodies is removed."""
        pair = one.body_id, other.body_id, link, other_link
        pybullet.setCollisionFilterPair(*pair, 0, **self._client)
        self._apart.add(pair)

    def forget(self, body: Body) -> None:
        """Call before a body is removed: PyBullet gives its number to another one."""
        gone = {pair for pair in self._apart if body.body_id in pair[:2]}
        for pair in gone:
            pybullet.setCollisionFilterPair(*pair, 1, **self._client)
        self._apart -= gone
        self._masks = {link: each for link, each in self._masks.items()
                       if link[0] != body.body_id}

    def forget_contacts(self) -> None:
        """Let the next step begin without contacts of an earlier one.

        PyBullet begins with their forces, which would make a difference after a reset. It forgets
        what a link touches when its mask is set; at first all meet nothing, so that nothing old is
        left among the new pairs. Then each link has a new number, and contacts are computed in the
        order of these numbers.
        """
        for link in self._masks:
            pybullet.setCollisionFilterGroupMask(*link, 0, 0, **self._client)
        for link, masks in self._masks.items():
            pybullet.setCollisionFilterGroupMask(*link, *masks, **self._client)

    def set_masks(self, body: FramedBody) -> None:
        """Set what the links of a body meet.

        Rays and contacts then find a body that was moved while it slept.
        """
        indices = link_indices(body.body_id, body.physics_client_id)
        static = links_of_base(body.body_id, body.physics_client_id) if body.fixed else ()
        for link in body.model.links:
            # all solids of a link have one mask in PyBullet
            for solid, name in itertools.product(link.solids[:1], (link.name, link.name + ACROSS)):
                if name in indices:
                    masks = groups_and_mask(solid.bitmask)
                    if solid.bitmask == ALL_BITS and indices[name] in static:
                        masks = _STATIC, ~_STATIC
                    self._masks[body.body_id, indices[name]] = masks
                    pybullet.setCollisionFilterGroupMask(
                        body.body_id, indices[name], *masks, **self._client)

    def _keep_apart(self, one: FramedBody, other: FramedBody) -> None:
        """Let links of two bodies of a model, or of one, only meet where Gazebo lets them."""
        joined = {frozenset(pair) for body in (one, other) for pair in _joined(body.model)}
        for (index, owner, space), (index2, owner2, space2) in itertools.product(
                _solid_links(one), _solid_links(other)):
            if owner == owner2 or space == space2 or frozenset((owner, owner2)) in joined:
                self.part(one, index, other, index2)


def _solid_links(body: FramedBody) -> Iterator[Tuple[int, str, str]]:
    """Yield the index of each link with solids, its owner and the space of that."""
    indices, owners = link_indices(body.body_id, body.physics_client_id), _owners(body.model)
    spaces = {link.name: link.space for link in body.model.links}
    for link in body.model.links:
        for name in (link.name, link.name + ACROSS):
            if link.solids and name in indices:
                yield indices[name], owners[link.name], spaces[owners[link.name]]


def _joined(model: Model) -> Iterator[Tuple[str, str]]:
    owners = _owners(model)
    return ((owners[joint.parent], owners[joint.child]) for joint in model.joints)


def _owners(model: Model) -> Dict[str, str]:
    """Return the link that each one is a part of: the next above it for those that were added
    when the model was read, which have no mass or no solids, else itself.
    """
    above = {joint.child: joint.parent for joint in model.joints}
    parts = {link.name for link in model.links if link.name in above and not (
        link.solids and link.inertia and link.inertia.mass)}
    owners = {}
    for link in model.links:
        owner = link.name
        while owner in parts:
            owner = above[owner]
        owners[link.name] = owner
    return owners
