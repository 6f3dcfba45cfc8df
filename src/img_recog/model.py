"""What a file says of robots and worlds, whoever wrote it, and what there is to draw of them.

Plain values: no XML but that of sensors, no physics, no OpenGL. Lengths are in m, angles in rad,
masses in kg.
"""
import math
from dataclasses import dataclass, field, replace
from typing import Any, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np

from img_recog import rotations
from img_recog.rotations import IDENTITY, Transform

Rgb = Tuple[float, float, float]                # from 0 to 1, not limited to them
Color = Tuple[float, float, float, float]       # and the opacity

# from the frame of a camera body (x forward, y to the left, z up) to OpenGL's (x right, y up,
# z backward)
BODY_TO_OPENGL = np.array([[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], float)

DIFFERENTIAL, PLANAR = 'differential', 'planar'       # drives
FIXED, CONTINUOUS, PRISMATIC, REVOLUTE = 'fixed', 'continuous', 'prismatic', 'revolute'  # joints
# shapes; the last two are not drawn
BOX, CYLINDER, SPHERE, PLANE, MESH = 'box', 'cylinder', 'sphere', 'plane', 'mesh'
CAPSULE, HEIGHTMAP = 'capsule', 'heightmap'
ALL_BITS = 0xffff       # of a solid that meets all others
PART = '::part_'        # between the name of a link and the rest of that of one with its solids
DIRECTIONAL, POINT, SPOT = 'directional', 'point', 'spot'       # lights
LINEAR, EXP, EXP2 = 'linear', 'exp', 'exp2'                     # fog
FLOOR_FRICTION = 1.0        # of what has no coefficient: Gazebo's default


class Submesh(NamedTuple):
    """A part of a mesh file; name: of its node, object or group, '' is the whole file.

    is_centered: whether the middle of its bounds is moved to the origin.
    """

    name: str = ''
    is_centered: bool = False


WHOLE = Submesh()


class Shape(NamedTuple):
    """A shape in its own frame, with its center at the origin, in m.

    kind and size: BOX (x, y, z); CYLINDER (radius, length along z); SPHERE (radius,); CAPSULE
    (radius, length along z without the ends); PLANE (x, y), of which the upper side is seen, and
    which carries without end; MESH
    (scale x, y, z), of the file `path` or a part of it; HEIGHTMAP (x, y, height of white,
    sampling), of the image `path`.
    """

    kind: str
    size: Tuple[float, ...]
    path: str = ''
    submesh: Submesh = WHOLE


class Material(NamedTuple):
    """What a surface does with light, as Ogre computes it.

    color: the share of the light of lamps that it sends in all directions, and the opacity;
    ambient: of that of the surroundings, None for that of `color`; specular: of that of lamps in a
    highlight, which is the smaller the higher the exponent `shininess` is, 0 for none; emissive:
    what it sends itself; texture: an image file that multiplies all but the highlight, '' for
    none; scale: how large its image is, 1 for all of the texture coordinates; is_cutout: whether
    the texture is only seen where it is opaque.
    """

    color: Color = (1.0, 1.0, 1.0, 1.0)
    texture: str = ''
    scale: Tuple[float, float] = (1.0, 1.0)
    is_cutout: bool = False
    ambient: Optional[Rgb] = None
    specular: Rgb = (0.0, 0.0, 0.0)
    shininess: float = 0.0
    emissive: Rgb = (0.0, 0.0, 0.0)

    def faded(self, opacity: float) -> 'Material':
        """Return the material of which a share of its opacity, 0 to 1, is left."""
        if self == WHITE:       # which Ogre draws twice, one over the other
            opacity = 1 - (1 - opacity) ** 2
        red, green, blue, own = self.color
        return self._replace(color=(red, green, blue, own * opacity))


# of what has no material: Gazebo/White
WHITE = Material(specular=(0.1, 0.1, 0.1), shininess=128.0)


class Inertia(NamedTuple):
    """A mass; pose: of its center, and of the axes of the inertia (3, 3) in kg m2 about that."""

    mass: float
    pose: Transform
    matrix: np.ndarray

    def moved(self, frame: Transform) -> 'Inertia':
        """Return this inertia, given in `frame`, in the parent of `frame`."""
        return self._replace(pose=frame @ self.pose)

    def plus(self, other: 'Inertia') -> 'Inertia':
        """Return the inertia of both together, about the axes of their frame."""
        mass = self.mass + other.mass
        if mass == 0:
            return NO_INERTIA
        center = (self.mass * self.pose.translation + other.mass * other.pose.translation) / mass
        return Inertia(mass, IDENTITY._replace(translation=center),
                       self._about(center) + other._about(center))

    def _about(self, point: np.ndarray) -> np.ndarray:
        """Return the inertia matrix about `point` (the parallel axis theorem)."""
        turn, arm = self.pose.rotation, self.pose.translation - point
        return turn @ self.matrix @ turn.T + self.mass * (
            arm @ arm * np.eye(3) - np.outer(arm, arm))


NO_INERTIA = Inertia(0.0, IDENTITY, np.zeros((3, 3)))


class Friction(NamedTuple):
    """Coefficients of a surface: mu along `direction` (3,), of any length, in the frame of the
    link, and mu2 across it, None for mu; without a direction, see physics/surfaces.py."""

    mu: float = FLOOR_FRICTION
    mu2: Optional[float] = None
    direction: Tuple[float, ...] = ()

    @property
    def across(self) -> float:
        """The coefficient across the direction."""
        return self.mu if self.mu2 is None else self.mu2

    @property
    def largest(self) -> float:
        """The larger one of both coefficients."""
        return max(self.mu, self.across)

    def at_most(self, limit: float) -> 'Friction':
        """Return this friction with no coefficient above a limit."""
        return self._replace(mu=min(self.mu, limit), mu2=min(self.across, limit))


class Contact(NamedTuple):
    """How what touches a surface is pushed out: as ODE has it, see physics/springs.py.

    stiffness: N/m; damping: N s/m; fastest: m/s; bounce: the share of its velocity with which it
    comes back; slack: m, from which depth on it is pushed out.
    """

    stiffness: float = 1e12
    damping: float = 1.0
    fastest: float = 0.01
    bounce: float = 0.0
    slack: float = 0.0

    @property
    def throws(self) -> bool:
        """Whether what falls onto it comes back: else ODE lets it out too slowly for that."""
        return self.fastest >= 10.0


class Solid(NamedTuple):
    """A collision shape at a pose in its link.

    friction: that which the file gives, None if it gives none; is_concave: whether a mesh is not
    replaced by its convex hull; bitmask: it meets those with which it has a bit in common.
    """

    shape: Shape
    pose: Transform = IDENTITY
    friction: Optional[Friction] = None
    is_concave: bool = False
    bitmask: int = ALL_BITS
    contact: Contact = Contact()

    @property
    def surface(self) -> Friction:
        """The friction that it is simulated with."""
        return self.friction or Friction()

    def moved(self, frame: Transform) -> 'Solid':
        """Return this solid, given in `frame`, in the parent of `frame`."""
        friction = self.friction
        if friction is not None and friction.direction:
            friction = friction._replace(
                direction=tuple((frame.rotation @ friction.direction).round(9).tolist()))
        return self._replace(pose=frame @ self.pose, friction=friction)


class Look(NamedTuple):
    """A shape that is seen, at a pose in its link.

    material: None is that of the mesh file, else WHITE; prefers_file: whether `material` is only
    used for what has none in the mesh file; opacity: by which that of a mesh file is multiplied.
    """

    shape: Shape
    pose: Transform = IDENTITY
    material: Optional[Material] = None
    prefers_file: bool = False
    opacity: float = 1.0


class Light(NamedTuple):
    """A lamp, or the sun.

    kind: DIRECTIONAL, POINT or SPOT; pose: in the world, or in its link; direction (3,): in which
    it shines, in its frame; reach: m; attenuation: what the light is divided by, constant, for
    each m and for each m2, but for a DIRECTIONAL; cone: of a SPOT, the angles across which it is
    bright and beyond which it is dark, and the exponent between them.
    """

    kind: str
    pose: Transform = IDENTITY
    diffuse: Rgb = (1.0, 1.0, 1.0)
    specular: Rgb = (0.1, 0.1, 0.1)
    direction: Tuple[float, float, float] = (0.0, 0.0, -1.0)
    reach: float = 10.0
    attenuation: Tuple[float, float, float] = (1.0, 1.0, 0.0)
    cone: Tuple[float, float, float] = (0.0, 0.0, 0.0)


# of Gazebo's model://sun
SUN = Light(DIRECTIONAL, diffuse=(0.8, 0.8, 0.8), specular=(0.2, 0.2, 0.2),
            direction=(-0.5, 0.1, -0.9))


class Fog(NamedTuple):
    """Fog. kind: LINEAR, from `start` to `end` in m, EXP or EXP2, by the density for each m."""

    kind: str
    color: Rgb = (1.0, 1.0, 1.0)
    start: float = 1.0
    end: float = 100.0
    density: float = 1.0


class Surroundings(NamedTuple):
    """What is around a world: ambient: the light that comes from everywhere."""

    ambient: Rgb = (0.4, 0.4, 0.4)
    background: Rgb = (0.7, 0.7, 0.7)
    has_sky: bool = False
    fog: Optional[Fog] = None


class Link(NamedTuple):
    """A rigid part.

    inertia: in its frame, None if the file gives none; contact: the numbers of PyBullet's
    <contact> in a URDF, by name. has_gravity: None if the file does not say it, which is yes.
    decay: the share of its velocity and of its angular velocity that it loses in each step.
    space: links of a model meet where their spaces differ, and no joint is between them. lights:
    at poses in the link.
    """

    name: str
    inertia: Optional[Inertia] = NO_INERTIA
    solids: Tuple[Solid, ...] = ()
    looks: Tuple[Look, ...] = ()
    contact: Mapping[str, float] = {}
    has_gravity: Optional[bool] = None
    decay: Tuple[float, float] = (0.0, 0.0)
    space: str = ''
    lights: Tuple[Light, ...] = ()

    @property
    def surface(self) -> Friction:
        """The friction of its solids, which PyBullet takes to be the same."""
        return self.solids[0].surface if self.solids else Friction()


class Limits(NamedTuple):
    """From and to where a joint moves, its largest torque or force, and its highest velocity.

    Of these two, the controllers of a robot take the first one; the physics does not.
    """

    lower: float
    upper: float
    effort: float = 1e9
    velocity: float = 1e9


class Joint(NamedTuple):
    """A joint between two links, given by their names.

    pose: of its frame, which is that of the child where the joint is at 0, in the parent; axis
    (3,): a unit vector in that frame; damping: N m s/rad or N s/m; friction: the torque or force
    that it takes to move it; stiffness: of its spring, N m/rad or N/m, which is at rest at
    `reference`, in rad or m. held: the largest force, in N or N m, with which a motor keeps it
    from moving; infinite if it keeps it at 0, and 0 if it is free.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose: Transform = IDENTITY
    axis: Optional[np.ndarray] = None
    limits: Optional[Limits] = None
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    reference: float = 0.0
    held: float = 0.0

    def held_at(self, position: float) -> 'Joint':
        """Return a joint that is fixed where this one is at a position in rad or m."""
        axis = np.asarray(self.axis)
        moved = IDENTITY._replace(translation=axis * position)
        if self.kind != PRISMATIC:
            moved = IDENTITY._replace(rotation=rotations.matrix(
                (*(axis * math.sin(position / 2)), math.cos(position / 2))))
        return Joint(self.name, FIXED, self.parent, self.child, self.pose @ moved)

    @property
    def nearest_to_0(self) -> float:
        """The position that its limits allow, in m or rad, nearest to 0."""
        low, high = (0.0, 0.0) if self.limits is None else self.limits[:2]
        return min(max(0.0, low), high) if low <= high else 0.0


class Gear(NamedTuple):
    """Keeps the position of `joint` at -`ratio` times that of `other`, in rad or m."""

    joint: str
    other: str
    ratio: float


class AttachedFrame(NamedTuple):
    """Where something is: its constant `pose` in a link."""

    link: str
    pose: Transform = IDENTITY


class Tag(NamedTuple):
    """What Gazebo is told of a link, or with `link` '' of the model: an element (of
    xml.etree.ElementTree) that has <sensor>s and <plugin>s, which formats/gazebo_tags.py reads.
    """

    link: str
    element: Any


@dataclass(frozen=True)
class Model:
    """Links that joints hold together as a tree.

    frames: where each link of the file is, also one that was lumped into another; surfaces: of
    each link of the file with a contact sensor, the links that have its solids and no others;
    tags: of its sensors and plugins; held: joints of an SDF that hold links fast; gears:
    between its joints; can_sleep: whether it may fall asleep if it has no joint that moves.
    """

    name: str
    links: Tuple[Link, ...]
    joints: Tuple[Joint, ...] = ()
    frames: Mapping[str, AttachedFrame] = field(default_factory=dict)
    surfaces: Mapping[str, Sequence[str]] = field(default_factory=dict)
    tags: Tuple[Tag, ...] = ()
    held: Tuple[str, ...] = ()
    gears: Tuple[Gear, ...] = ()
    can_sleep: bool = True

    def held_at(self, positions: Mapping[str, float]) -> 'Model':
        """Return the model with some joints fixed at positions in rad or m, by their names."""
        return replace(self, joints=tuple(
            joint.held_at(positions[joint.name]) if joint.name in positions else joint
            for joint in self.joints))

    @property
    def roots(self) -> Tuple[str, ...]:
        """The names of the links that are the child of no joint: one, if they are a tree."""
        children = {joint.child for joint in self.joints}
        return tuple(link.name for link in self.links if link.name not in children)

    @property
    def root(self) -> str:
        """The name of the first root link."""
        return self.roots[0]

    @property
    def files(self) -> Set[str]:
        """The paths of its meshes, images of terrain and textures."""
        looks = [look for link in self.links for look in link.looks]
        shapes = [each.shape for each in looks] + [
            solid.shape for link in self.links for solid in link.solids]
        return {path for path in (*(shape.path for shape in shapes),
                                  *(look.material.texture for look in looks if look.material))
                if path}

    @property
    def terrain(self) -> Optional[Shape]:
        """The heightmap that it is, None if it is something else."""
        shapes = [solid.shape for link in self.links for solid in link.solids]
        return shapes[0] if shapes and shapes[0].kind == HEIGHTMAP else None

    @property
    def is_plane(self) -> bool:
        """Whether a plane carries what is on it."""
        return any(solid.shape.kind == PLANE for link in self.links for solid in link.solids)


class Tree(NamedTuple):
    """A tree of links in a world: a model, or the part of one that joints hold together.

    name: of the model, with ::LINK for those after the first; pose: of the root link in the
    world; fixed: whether that never moves; in_model: the pose of the root link in the frame of the
    model; first: whether it is the first of its model; positions: of joints at the start, in rad
    or m, by name.
    """

    name: str
    model: Model
    pose: Transform = IDENTITY
    fixed: bool = False
    in_model: Transform = IDENTITY
    first: bool = True
    positions: Mapping[str, float] = {}


class Visual(NamedTuple):
    """A look in a scene: part: the number of its link, whose frame moves; pose (4, 4): of the
    shape in that frame, a homogeneous transform; the rest as in Look."""

    part: int
    shape: Shape
    pose: np.ndarray
    material: Optional[Material] = None
    prefers_file: bool = False
    opacity: float = 1.0


class VisualScene(NamedTuple):
    """What there is to draw.

    moving: whether the part of each number can move; lights: each with the number of its part, -1
    for the world; floor: whether there is a floor at z 0.
    """

    visuals: Tuple[Visual, ...]
    moving: Tuple[bool, ...]
    lights: Tuple[Tuple[int, Light], ...] = ()
    surroundings: Surroundings = Surroundings()
    floor: bool = False
