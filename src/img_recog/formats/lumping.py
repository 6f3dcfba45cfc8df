"""Makes a robot of the links and joints of a URDF, as they can be simulated.

Every fixed joint costs PyBullet time in each step. Therefore fixed links are lumped into the link
that they are fixed to, like Gazebo's SDFormat does: shapes are moved, masses and inertias added
up, and `frames` keeps where each link went. PyBullet has one surface and one bitmask per link:
shapes with others than the link that they are lumped into go to a link without mass, which is
fixed to that. So do those of an SDF.
"""
import dataclasses
import itertools
from typing import Dict, List, Mapping, NamedTuple, Set, Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.model import (CONTINUOUS, FIXED, NO_INERTIA, PART, PRISMATIC, REVOLUTE,
                             AttachedFrame, Contact, Friction, Inertia, Joint, Light, Link, Look,
                             Model, Solid)
from img_recog.report import NOT_SIMULATED, Report
from img_recog.rotations import IDENTITY

INERTIA_KEYS = ('ixx', 'ixy', 'ixz', 'ixy', 'iyy', 'iyz', 'ixz', 'iyz', 'izz')   # row by row
# kg: in PyBullet, a body of 1e300 kg falls through the floor
_MIN_MASS, _MAX_MASS = 1e-20, 1e9
_MAX_MOMENT, _NO_MOMENT = 1e15, 1e-20       # kg m2
# of the largest moment: above what PyBullet's search for the principal axes can miss
_MARGIN = 1e-5
_SAID_FROM = 1e-3                           # of the largest moment: what is told to the user
_RADIUS_OF_GYRATION_M = 0.01                # of a body whose file gives it no moment at all
_KINDS = (CONTINUOUS, FIXED, PRISMATIC, REVOLUTE)


def check_mass(name: str, mass: float, otherwise: str = '') -> None:
    """Raise SimulationError unless a mass in kg can be used; otherwise: what else is allowed.

    >>> check_mass('mass of link a', 0.0)
    Traceback (most recent call last):
    img_recog.errors.SimulationError: mass of link a: got 0 kg, expected more than 0
    """
    if not _MIN_MASS <= mass <= _MAX_MASS:
        limit = 'more than 0' if mass < _MIN_MASS else 'at most {:g}'.format(_MAX_MASS)
        raise SimulationError('{}: got {:g} kg, expected {}{}'.format(
            name, mass, limit, otherwise))


def possible_inertia(name: str, mass: float, matrix: np.ndarray, report: Report) -> np.ndarray:
    """Return the inertia nearest to `matrix` (3, 3) that a body of `mass` kg can have.

    The principal moments of a body are positive, and none exceeds the sum of the others; PyBullet
    replaces all of them by 0 otherwise, and then the body does not turn at all. name: of the
    body; report: gets a finding if the inertia that is returned makes a difference.
    Raises SimulationError when a moment is too large to be simulated.
    """
    moments, axes = np.linalg.eigh(matrix)
    if moments[2] > _MAX_MOMENT:
        raise SimulationError('{}: got the moment of inertia {:g} kg m2, expected at most {:g}'
                              .format(name, moments[2], _MAX_MOMENT))
    margin = _MARGIN * moments[2]
    if moments[2] > _NO_MOMENT and moments[0] + moments[1] - moments[2] >= margin:
        return matrix
    nearest = _nearest(moments) + margin
    if nearest[2] < _NO_MOMENT:
        nearest = np.full(3, mass * _RADIUS_OF_GYRATION_M ** 2)
    if np.abs(nearest - moments).max() > _SAID_FROM * nearest[2]:
        report.assume('inertia of {}: the nearest possible one'.format(name), (
            '{}: got the principal moments of inertia {} kg m2; those of a body are more than 0, '
            'and none exceeds the sum of the others; simulated with {}'.format(
                name, *(', '.join(map('{:.3g}'.format, each)) for each in (moments, nearest)))))
    return axes @ np.diag(nearest) @ axes.T


def _nearest(moments: np.ndarray) -> np.ndarray:
    """Return the moments nearest to those given, in rising order, of which none exceeds the sum
    of the others.

    They form a cone: the sums of the rays (0, 1, 1), (1, 0, 1) and (1, 1, 0).
    """
    excess = max(moments[2] - moments[0] - moments[1], 0.0)
    on_plane = moments + np.array((excess, excess, -excess)) / 3
    if on_plane[0] >= 0:
        return on_plane
    return np.array((0.0, 1.0, 1.0)) * max((moments[1] + moments[2]) / 2, 0.0)


class _Tree(NamedTuple):
    """links: by name, none before that which it is joined to; parents: the joint above each link
    but the root, by the name of the link; root: its name."""

    links: Dict[str, Link]
    parents: Dict[str, Joint]
    root: str


def lumped(model: Model, report: Report) -> Model:
    """Return a robot: the links of a model that move, with what is fixed to them.

    report: gets what is left out, and inertias that are changed.
    Raises SimulationError when the links are not a tree, a joint has a type that is not simulated,
    or a mass cannot be simulated.
    """
    tree = _tree(model)
    frames = {name: _frame(name, tree) for name in tree.links}
    sums = _inertias(tree, frames)
    _leave_out(tree, frames, sums, report)
    lump = _Lump(model, tree.links, frames)
    for name, total in sums.items():
        sums[name] = total._replace(matrix=possible_inertia(
            'link {} and what is fixed to it'.format(name), total.mass, total.matrix, report))
    moving = tuple(joint._replace(parent=frames[joint.parent].link,
                                  pose=frames[joint.parent].pose @ joint.pose)
                   for joint in model.joints if joint.child in sums)
    return dataclasses.replace(
        model, links=(*(lump.link(link, sums[link.name]) for link in model.links
                        if link.name in sums), *lump.added_links()),
        joints=moving + lump.added_joints(), frames=frames,
        surfaces={name: tuple(found) for name, found in lump.watched.items()})


def divided(model: Model) -> Model:
    """Return a model whose links stay as they are, but for shapes with another surface or bitmask
    than the first one of their link: those go to a link without mass, too."""
    lump = _Lump(model, {link.name: link for link in model.links},
                 {link.name: AttachedFrame(link.name) for link in model.links})
    return dataclasses.replace(
        model, links=(*(link._replace(solids=tuple(lump.solids.get(link.name, ())))
                        for link in model.links), *lump.added_links()),
        joints=(*model.joints, *lump.added_joints()),
        surfaces={name: tuple(found) for name, found in lump.watched.items()})


def _tree(model: Model) -> _Tree:
    links = {link.name: link for link in model.links}
    parents: Dict[str, Joint] = {}
    children: Dict[str, List[str]] = {}
    for joint in model.joints:
        if joint.child in parents:
            raise SimulationError('link {} is the child of two joints, {} and {}'.format(
                joint.child, parents[joint.child].name, joint.name))
        parents[joint.child] = joint
        children.setdefault(joint.parent, []).append(joint.child)
    for joint in model.joints:
        if joint.kind not in _KINDS:
            raise SimulationError('joint {} is of type {}; supported are {}'.format(
                joint.name, joint.kind, ', '.join(_KINDS)))
    for name in links:
        _check_ancestors(name, parents)
    if len(model.roots) != 1:
        raise SimulationError('got {} root links ({}), expected one'.format(
            len(model.roots), ', '.join(model.roots)))
    names = list(model.roots)
    for name in names:          # grows while it is iterated over
        names += children.get(name, [])
    return _Tree({name: links[name] for name in names}, parents, names[0])


def _check_ancestors(name: str, parents: Dict[str, Joint]) -> None:
    """Raise SimulationError when a link is joined to itself by others."""
    ancestors, link = {name}, name
    while link in parents:
        link = parents[link].parent
        if link in ancestors:
            raise SimulationError('link {} is its own ancestor, through joint {}'.format(
                link, parents[link].name))
        ancestors.add(link)


def _frame(name: str, tree: _Tree) -> AttachedFrame:
    pose, carrier = IDENTITY, name
    while carrier in tree.parents and tree.parents[carrier].kind == FIXED:
        joint = tree.parents[carrier]
        pose = joint.pose @ pose
        carrier = joint.parent
    return AttachedFrame(carrier, pose)


def _inertias(tree: _Tree, frames: Dict[str, AttachedFrame]) -> Dict[str, Inertia]:
    """Return the inertia of each lumped link, by its name."""
    sums: Dict[str, Inertia] = {}
    for name, frame in frames.items():
        own = tree.links[name].inertia or NO_INERTIA
        sums[frame.link] = sums.get(frame.link, NO_INERTIA).plus(own.moved(frame.pose))
    return sums


def _leave_out(tree: _Tree, frames: Dict[str, AttachedFrame],
               sums: Dict[str, Inertia], report: Report) -> None:
    """Remove the lumped links without mass, and what is joined to them, as Gazebo's SDFormat does.

    Raises SimulationError when that is the whole robot.
    """
    if sums[tree.root].mass == 0:
        raise SimulationError('link {} can move but has no mass'.format(tree.root),
                              'add an <inertial> to it or to a link fixed to it')
    gone: Set[str] = set()
    for name in sums:     # from the root on
        above = frames[tree.parents[name].parent].link if name in tree.parents else ''
        if sums[name].mass and above not in gone:
            continue
        gone.add(name)
        if above not in gone:
            report.add(NOT_SIMULATED, 'link {} with joint {} and all that is joined to it'.format(
                name, tree.parents[name].name), advice='it can move but has no mass, so it is '
                'left out as in Gazebo; give it an <inertial>')
    names = [name for name, frame in frames.items() if frame.link in gone]
    for name in names:
        del frames[name]
    for name in gone:
        del sums[name]


class _Lump:
    """The shapes of all links, moved to the lumped links or to links that are added to those.

    watched: of each link with a contact sensor, the names of the links with its shapes; solids:
    of each of these links.
    """

    def __init__(self, model: Model, links: Mapping[str, Link],
                 frames: Mapping[str, AttachedFrame]):
        self.watched: Dict[str, List[str]] = {name: [] for name in model.surfaces}
        self._looks: Dict[str, List[Look]] = {frame.link: [] for frame in frames.values()}
        self._lights: Dict[str, List[Light]] = {frame.link: [] for frame in frames.values()}
        self.solids: Dict[str, List[Solid]] = {}
        self._carriers: Dict[str, str] = {}         # of the links that are added
        self._parts: Dict[str, List[Link]] = {}     # of the lumped links
        surfaces: Dict[Tuple[str, Friction, int, Contact, str], str] = {}
        for name, (carrier, pose) in frames.items():
            self._parts.setdefault(carrier, []).append(links[name])
            self._looks[carrier] += [look._replace(pose=pose @ look.pose)
                                     for look in links[name].looks]
            self._lights[carrier] += [light._replace(pose=pose @ light.pose)
                                      for light in links[name].lights]
            for solid in links[name].solids:
                solid = solid.moved(pose)
                key = (carrier, solid.surface, solid.bitmask, solid.contact,
                       name if name in self.watched else '')
                if key not in surfaces:
                    surfaces[key] = self._surface(name, carrier, solid)
                self.solids[surfaces[key]].append(solid)

    def _surface(self, name: str, carrier: str, solid: Solid) -> str:
        """Return the name of the link for a shape of a link that goes to a lumped link."""
        surface = carrier
        if carrier in self.solids:
            taken = name in self.solids or name == carrier
            surface = next('{}{}{}'.format(name, PART, number) for number in itertools.count(1)
                           if name + PART + str(number) not in self.solids) if taken else name
            self._carriers[surface] = carrier
        self.solids[surface] = []
        if name in self.watched:
            self.watched[name].append(surface)
        return surface

    def link(self, link: Link, inertia: Inertia) -> Link:
        """Return a lumped link; of what its parts say of how it moves, the last counts."""
        for part in self._parts[link.name]:
            link = link._replace(
                has_gravity=link.has_gravity if part.has_gravity is None else part.has_gravity,
                decay=part.decay if any(part.decay) else link.decay,
                space=part.space or link.space)
        return link._replace(inertia=inertia, solids=tuple(self.solids.get(link.name, ())),
                             looks=tuple(self._looks[link.name]),
                             lights=tuple(self._lights[link.name]))

    def added_links(self) -> Tuple[Link, ...]:
        """Return the links without mass."""
        return tuple(Link(name, solids=tuple(self.solids[name])) for name in self._carriers)

    def added_joints(self) -> Tuple[Joint, ...]:
        """Return the joints that fix them."""
        return tuple(Joint(name + '/joint', FIXED, carrier, name)
                     for name, carrier in self._carriers.items())
