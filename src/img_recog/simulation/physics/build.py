"""Builds models in a physics client: the one writer of what PyBullet reads.

That is the text of a URDF in PyBullet's dialect, and calls for what that has not.
"""
import contextlib
import os
import tempfile
import xml.etree.ElementTree as ElementTree
from typing import Iterator, Optional

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats import allowed_names, heightmaps
from img_recog.formats.lumping import INERTIA_KEYS
from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import MeshError
from img_recog.formats.reader import words
from img_recog.model import (BOX, CAPSULE, CYLINDER, MESH, PLANE, SPHERE, Inertia, Joint, Link,
                             Look, Material, Model, Shape, Solid)
from img_recog.report import LEFT_OUT, Report
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.physics import mesh_cache
from img_recog.simulation.physics.collision_filters import has_spaces

_MAX_JOINTS = 127       # of a body, in PyBullet: MAX_DEGREE_OF_FREEDOM is 128
_MARGIN_M = 0.001       # of the convex hulls of meshes in PyBullet
_PLANE_THICKNESS_M = 0.01       # below the plane
_NOTHING = Look(Shape(BOX, (0.0, 0.0, 0.0)))
# exact cylinders: the default, a convex hull, is 1 mm larger and rolls on facets
_URDF_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
_ATTRIBUTES = {CYLINDER: ('radius', 'length'), CAPSULE: ('radius', 'length'),
               SPHERE: ('radius',)}


def load(model: Model, physics_client_id: int, fixed: bool = False, pose: Transform = IDENTITY,
         visuals: bool = False, report: Optional[Report] = None,
         exact_hulls: bool = False) -> int:
    """Load a model; return its body's id.

    fixed: whether the root link never moves; pose: of the root link in the world; visuals: whether
    to load the looks as well, which only a window needs; those with a mesh that cannot be read are
    left out. report: gets what is left out because a mesh of a solid cannot be read, which is an
    error without. exact_hulls: whether the convex hulls of meshes are as large
    as the meshes, and not 1 mm larger on each side.
    Raises SimulationError when PyBullet cannot load it, or would crash.
    """
    allowed_names.check_all(model)
    if len(model.joints) > _MAX_JOINTS:
        raise SimulationError('it has {} joints, and PyBullet takes at most {}'.format(
            len(model.joints), _MAX_JOINTS), 'divide it into several models')
    if model.terrain is not None:
        return _load_terrain(model.terrain, physics_client_id, pose)
    with tempfile.TemporaryDirectory(prefix='img_recog_') as folder:    # for meshes of looks
        robot = ElementTree.Element('robot', name=model.name)
        for link in model.links:
            solids = list(_solids(link, report, exact_hulls))
            # without any, PyBullet shows the collision shapes, and reads their meshes again
            looks = list(_looks(link, folder) if visuals else ()) or [_NOTHING]
            _add_link(robot, link._replace(solids=tuple(solids), looks=tuple(looks)))
        for joint in model.joints:
            _add_joint(robot, joint)
        with _file(ElementTree.tostring(robot, 'unicode')) as path, _refusal('URDF'):
            return pybullet.loadURDF(
                path, pose.translation.tolist(), rotations.quaternion_of(pose.rotation),
                useFixedBase=fixed, physicsClientId=physics_client_id,
                flags=_URDF_FLAGS | pybullet.URDF_USE_SELF_COLLISION * has_spaces(model))


def _solids(link: Link, report: Optional[Report], exact_hulls: bool) -> Iterator[Solid]:
    """Yield the solids of a link, with meshes from the cache."""
    for solid in link.solids:
        try:
            if solid.shape.kind == MESH:
                solid = solid._replace(shape=solid.shape._replace(
                    path=mesh_cache.cached(solid.shape.path, solid.shape.submesh)))
        except SimulationError as error:
            if report is None:
                raise
            report.add(LEFT_OUT, error.problem, advice=error.advice)
            continue
        if exact_hulls and solid.shape.kind == MESH and not solid.is_concave:
            solid = _shrunk(solid)
        yield solid


def _shrunk(solid: Solid) -> Solid:
    """Take from a mesh on each side what PyBullet's margin adds to its convex hull."""
    low, high = mesh_cache.bounds(solid.shape.path)
    scale = np.array(solid.shape.size)
    sizes = np.maximum((high - low) * np.abs(scale), 1e-9)
    factors = np.where(sizes > 4 * _MARGIN_M, 1 - 2 * _MARGIN_M / sizes, 1.0)
    middle = (low + high) / 2 * scale
    return solid._replace(
        shape=solid.shape._replace(size=tuple((scale * factors).tolist())),
        pose=solid.pose._replace(translation=solid.pose.apply((1 - factors) * middle)))


def _looks(link: Link, folder: str) -> Iterator[Look]:
    """Yield the looks of a link, with meshes in files that PyBullet can read."""
    for look in link.looks:
        shape = look.shape
        with contextlib.suppress(MeshError):
            if shape.kind == MESH:
                shape = shape._replace(path=mesh_file.write(
                    shape.path, tempfile.mkdtemp(dir=folder), materials=True,
                    submesh=shape.submesh))
            yield look._replace(shape=shape)


def _add_link(robot: ElementTree.Element, link: Link) -> None:
    element = ElementTree.SubElement(robot, 'link', name=link.name)
    if link.inertia is not None:
        _add_inertia(element, link.inertia)
    if link.contact:
        owner = ElementTree.SubElement(element, 'contact')
        for name, value in link.contact.items():
            ElementTree.SubElement(owner, name, value=words([value]))
    for solid in link.solids:
        added = ElementTree.SubElement(element, 'collision')
        if solid.is_concave and solid.shape.kind == MESH:
            added.set('concave', 'yes')
        _add_shape(added, solid.shape, solid.pose)
    for look in link.looks:
        added = ElementTree.SubElement(element, 'visual')
        _add_shape(added, look.shape, look.pose)
        if look.material is not None:
            _add_material(added, look.material)


def _add_inertia(link: ElementTree.Element, inertia: Inertia) -> None:
    """Add the inertia also of what never moves: without it, PyBullet warns and assumes 1 kg."""
    element = ElementTree.SubElement(link, 'inertial')
    _add_origin(element, inertia.pose)
    ElementTree.SubElement(element, 'mass', value=words([inertia.mass]))
    ElementTree.SubElement(element, 'inertia', {
        key: words([value]) for key, value in zip(INERTIA_KEYS, inertia.matrix.flat)})


def _add_shape(owner: ElementTree.Element, shape: Shape, pose: Transform) -> None:
    kind, size = shape.kind, shape.size
    if kind == PLANE and owner.tag == 'collision':
        attributes = {'normal': '0 0 1'}
    elif kind == PLANE:         # a thin box, whose upper side is the plane
        kind, pose = BOX, pose @ IDENTITY._replace(
            translation=np.array((0, 0, -_PLANE_THICKNESS_M / 2)))
        attributes = {'size': words((*size, _PLANE_THICKNESS_M))}
    elif kind == BOX:
        attributes = {'size': words(size)}
    elif kind == MESH:
        attributes = {'filename': shape.path, 'scale': words(size)}
    else:
        attributes = dict(zip(_ATTRIBUTES[kind], words(size).split()))
    _add_origin(owner, pose)
    ElementTree.SubElement(ElementTree.SubElement(owner, 'geometry'), kind, attributes)


def _add_material(visual: ElementTree.Element, material: Material) -> None:
    # a name for each: in a URDF, materials of one name are the same
    element = ElementTree.SubElement(visual, 'material', name=' '.join(map(str, material)))
    ElementTree.SubElement(element, 'color', rgba=words(material.color))
    if material.texture:
        ElementTree.SubElement(element, 'texture', filename=material.texture)


def _add_joint(robot: ElementTree.Element, joint: Joint) -> None:
    element = ElementTree.SubElement(robot, 'joint', name=joint.name, type=joint.kind)
    _add_origin(element, joint.pose)
    ElementTree.SubElement(element, 'parent', link=joint.parent)
    ElementTree.SubElement(element, 'child', link=joint.child)
    if joint.axis is not None:
        ElementTree.SubElement(element, 'axis', xyz=words(joint.axis))
    if joint.limits is not None:
        ElementTree.SubElement(element, 'limit', {
            name: words([value]) for name, value in joint.limits._asdict().items()})
    if joint.damping or joint.friction:
        ElementTree.SubElement(element, 'dynamics', damping=words([joint.damping]),
                               friction=words([joint.friction]))


def _add_origin(element: ElementTree.Element, pose: Transform) -> None:
    ElementTree.SubElement(element, 'origin', xyz=words(pose.translation),
                           rpy=words(rotations.to_rpy(pose.rotation)))


def _load_terrain(shape: Shape, physics_client_id: int, pose: Transform) -> int:
    """Load a heightmap, the middle of whose heights is at `pose`."""
    heights, size = heightmaps.read(shape)
    rows, columns = heights.shape
    client = {'physicsClientId': physics_client_id}
    # PyBullet means by rows the points along x
    solid = pybullet.createCollisionShape(
        pybullet.GEOM_HEIGHTFIELD, meshScale=(size[0] / (columns - 1), size[1] / (rows - 1), 1),
        heightfieldData=heights.ravel().tolist(), numHeightfieldRows=columns,
        numHeightfieldColumns=rows, **client)
    # without a visual shape, PyBullet makes one of all triangles
    visual = pybullet.createVisualShape(pybullet.GEOM_SPHERE, radius=1e-4, **client)
    with _refusal('heightmap'):
        return pybullet.createMultiBody(0, solid, visual, pose.translation.tolist(),
                                        rotations.quaternion_of(pose.rotation), **client)


@contextlib.contextmanager
def _refusal(kind: str) -> Iterator[None]:
    try:
        yield
    except pybullet.error as error:
        raise SimulationError('PyBullet cannot load it as {} ({})'.format(kind, error),
                              "see PyBullet's own lines above for the reason")


@contextlib.contextmanager
def _file(text: str) -> Iterator[str]:
    """Give the path of a file in memory that holds the XML `text`."""
    descriptor = os.memfd_create('description')
    try:
        with os.fdopen(descriptor, 'w', closefd=False) as file:
            # PyBullet reads lines and breaks each after 8191 bytes, even within a number
            file.write(text.replace('><', '>\n<'))
        yield '/proc/self/fd/{}'.format(descriptor)
    finally:
        os.close(descriptor)
