"""Which links meet, as in Gazebo: by bitmasks, and those of a model that it lets collide."""
import itertools
from typing import Dict, Iterator, Sequence, Set, Tuple

import pybullet

from img_recog.model import ALL_BITS, BOX, PLANE, Link, Model
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import client_argument, links_of_base
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tires import wheel_of

# Two links collide in PyBullet if a group of one is in the mask of the other. A link without a
# bitmask collides with all groups but those that its kind leaves out, and so does a ray, which is
# in the group of what moves. The bits of a file's bitmask are shifted beyond these groups.
_MOVING, _STATIC, _FLOOR, _WHEEL, _TREADS, _SHIFT = 1, 2, 4, 8, 16, 8

# PyBullet finds one edge of a wheel on a sill. The treads add the other one, and the wheel itself
# also meets what is between them.
_COLLIDES = {_MOVING: ~_TREADS, _STATIC: ~(_STATIC | _FLOOR), _TREADS: _STATIC | _FLOOR,
             _FLOOR: ~(_STATIC | _FLOOR | _WHEEL), _WHEEL: ~(_FLOOR | _TREADS)}

_MIN_FLOOR_M = 1.0
_Pair = Tuple[int, int, int, int]        # two bodies, and a link of each


def has_spaces(model: Model) -> bool:
    """Return whether some links of a model meet one another."""
    return len({link.space for link in model.links if link.solids}) > 1


def _groups_and_mask(bitmask: int, kind: int) -> Tuple[int, int]:
    """Return the groups of PyBullet that a link is in, and those that it collides with."""
    if bitmask != ALL_BITS:
        groups = bitmask << _SHIFT
        return groups, groups and groups | _MOVING
    return kind, _COLLIDES[kind]


class Meeting:
    """What the links of bodies in a physics client meet."""

    def __init__(self, physics_client_id: int):
        self._client = client_argument(physics_client_id)
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
            # what hangs on hinges moves even if its base is fixed
            if any(not body.fixed or body.joints for body in (one, other)):
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

        PyBullet begins with their forces, which would make a difference after a reset. At first
        all links collide with nothing, so that nothing old is left among the new pairs. Then each
        link has a new number, and contacts are computed in the order of these numbers.
        """
        for link in self._masks:
            pybullet.setCollisionFilterGroupMask(*link, 0, 0, **self._client)
        for link in self._masks:
            self.forget_contacts_of(link)

    def forget_contacts_of(self, link: Tuple[int, int]) -> None:
        """Let PyBullet make new contacts of a link, by the numbers of its body and of the link.

        PyBullet forgets what a link touches when its mask is set.
        """
        if link in self._masks:
            pybullet.setCollisionFilterGroupMask(*link, *self._masks[link], **self._client)

    def set_masks(self, body: FramedBody) -> None:
        """Set what the links of a body meet.

        Rays and contacts then find a body that was moved while it slept.
        """
        static = links_of_base(body.body_id, body.physics_client_id) if body.fixed else ()
        floors = {link.name for link in body.model.links if _is_floor(link)}
        # all solids of a link have one mask in PyBullet
        bitmasks = {link.name: link.solids[0].bitmask for link in body.model.links if link.solids}
        wheels = {wheel_of(name) for name in body.link_indices if name != wheel_of(name)}
        for name, index in body.link_indices.items():
            wheel = wheel_of(name)
            if wheel in bitmasks:
                kind = _TREADS if name != wheel else _WHEEL if wheel in wheels else _MOVING
                if index in static:
                    kind = _FLOOR if body.is_terrain or name in floors else _STATIC
                masks = _groups_and_mask(bitmasks[wheel], kind)
                self._masks[body.body_id, index] = masks
                pybullet.setCollisionFilterGroupMask(body.body_id, index, *masks, **self._client)

    def _keep_apart(self, one: FramedBody, other: FramedBody) -> None:
        """Let links of two bodies of a model, or of one, only meet where Gazebo lets them."""
        joined = {frozenset(pair) for body in (one, other) for pair in _joined(body.model)}
        for (index, owner, space), (index2, owner2, space2) in itertools.product(
                _solid_links(one), _solid_links(other)):
            if owner == owner2 or space == space2 or frozenset((owner, owner2)) in joined:
                self.part(one, index, other, index2)


def _is_floor(link: Link) -> bool:
    """Return whether robots can drive on all solids of a link that never moves."""
    return all(solid.shape.kind == PLANE or solid.shape.kind == BOX
               and min(solid.shape.size[:2]) >= _MIN_FLOOR_M for solid in link.solids)


def _solid_links(body: FramedBody) -> Iterator[Tuple[int, str, str]]:
    """Yield the index of each link with solids, its owner and the space of that."""
    owners = _owners(body.model)
    spaces = {link.name: link.space for link in body.model.links}
    solid = {link.name for link in body.model.links if link.solids}
    for name, index in body.link_indices.items():
        wheel = wheel_of(name)
        if wheel in solid:
            yield index, owners[wheel], spaces[owners[wheel]]


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
