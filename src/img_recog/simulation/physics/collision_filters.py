"""Filters of collisions, as in Gazebo: bitmasks, and links of a model that do not collide."""
import itertools
from typing import Dict, Iterator, Sequence, Tuple

from img_recog.model import ALL_BITS, BOX, PLANE, Link, Model
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tires import TREAD

# Two links collide in PyBullet if a group of one is in the mask of the other. A link without a
# bitmask collides with all groups but those that its kind leaves out, and so does a ray, which is
# in the group of what moves. The bits of a file's bitmask are shifted beyond these groups.
_MOVING, _STATIC, _FLOOR, _WHEEL, _TREADS, _SHIFT = 1, 2, 4, 8, 16, 8

# PyBullet finds one edge of a wheel on a sill. The treads add the other one, and the wheel itself
# also meets what is between them.
_COLLIDES = {_MOVING: ~_TREADS, _STATIC: ~(_STATIC | _FLOOR), _TREADS: _STATIC | _FLOOR,
             _FLOOR: ~(_STATIC | _FLOOR | _WHEEL), _WHEEL: ~(_FLOOR | _TREADS)}

_MIN_FLOOR_M = 1.0
Pair = Tuple[int, int, int, int]        # two bodies, and a link of each


def has_spaces(model: Model) -> bool:
    """Return whether some links of a model meet one another."""
    return len({link.space for link in model.links if link.solids}) > 1


def _groups_and_mask(bitmask: int, kind: int) -> Tuple[int, int]:
    """Return the groups of PyBullet that a link is in, and those that it collides with."""
    if bitmask != ALL_BITS:
        groups = bitmask << _SHIFT
        return groups, groups and groups | _MOVING
    return kind, _COLLIDES[kind]


def of_links(body: FramedBody) -> Dict[int, Tuple[int, int]]:
    """Return the groups and the mask of each link with solids, by PyBullet's indices."""
    static = body.static_links
    floors = {link.name for link in body.model.links if _is_floor(link)}
    # all solids of a link have one mask in PyBullet
    bitmasks = body.of_solids(lambda link: link.solids[0].bitmask)
    found = {}
    for name, index in body.link_indices.items():
        if index in bitmasks:
            kind = (_TREADS if TREAD in name else _WHEEL if name in body.with_treads else _MOVING)
            if index in static:
                kind = _FLOOR if body.is_terrain or name in floors else _STATIC
            found[index] = _groups_and_mask(bitmasks[index], kind)
    return found


def apart(bodies: Sequence[FramedBody]) -> Iterator[Pair]:
    """Yield the pairs of links of a model that do not collide in Gazebo."""
    for one, other in itertools.combinations_with_replacement(bodies, 2):
        # what hangs on hinges moves even if its base is fixed
        if (has_spaces(one.model) if one is other else any(
                not body.fixed or body.joints for body in (one, other))):
            joined = {frozenset(pair) for body in (one, other) for pair in _joined(body.model)}
            for (index, owner, space), (index2, owner2, space2) in itertools.product(
                    _solid_links(one), _solid_links(other)):
                if owner == owner2 or space == space2 or frozenset((owner, owner2)) in joined:
                    yield one.body_id, other.body_id, index, index2


def _is_floor(link: Link) -> bool:
    """Return whether robots can drive on all solids of a link that never moves."""
    return all(solid.shape.kind == PLANE or solid.shape.kind == BOX
               and min(solid.shape.size[:2]) >= _MIN_FLOOR_M for solid in link.solids)


def _solid_links(body: FramedBody) -> Iterator[Tuple[int, str, str]]:
    """Yield the index of each link with solids, its owner and the space of that."""
    owners = _owners(body.model)
    spaces = {link.name: link.space for link in body.model.links}
    for index, owner in body.of_solids(lambda link: owners[link.name]).items():
        yield index, owner, spaces[owner]


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
