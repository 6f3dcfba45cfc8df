"""Loads the text of a URDF into a physics client."""
import contextlib
import os
import tempfile
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, Optional, Tuple

import numpy as np
import pybullet

from img_recog import mesh_file, rotations
from img_recog.mesh_file import MeshError
from img_recog.simulation.bodies import mesh_cache
from img_recog.simulation.descriptions import heightmaps, names, urdf_visuals
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import read_lengths, words
from img_recog.simulation.descriptions.problems import Problems
from img_recog.simulation.descriptions.urdf_elements import origin_of, set_origin
from img_recog.simulation.settings import SimulationError

_MARGIN_M = 0.001       # of the convex hulls of meshes in PyBullet
_NOTHING = '<visual><geometry><box size="0 0 0"/></geometry></visual>'
# exact cylinders: the default, a convex hull, is 1 mm larger and rolls on facets
_URDF_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER


def connect(mode: int = pybullet.DIRECT, options: str = '') -> int:
    """Return the id of a new physics client, by default one without a window."""
    # with an empty options argument, PyBullet prints it
    physics_client_id = pybullet.connect(mode, **({'options': options} if options else {}))
    if physics_client_id < 0:
        raise SimulationError('PyBullet cannot start a physics client',
                              'check whether too many are in use')
    # its cache goes by file name, and `_file` gives each text the same one
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=physics_client_id)
    return physics_client_id


@contextlib.contextmanager
def all_or_nothing(physics_client_id: int) -> Iterator[None]:
    """Remove the bodies that were loaded in the `with` block if it raises an error."""
    before = set(body_ids(physics_client_id))
    try:
        yield
    except Exception:
        for body_id in set(body_ids(physics_client_id)) - before:
            pybullet.removeBody(body_id, physicsClientId=physics_client_id)
        raise


def body_ids(physics_client_id: int) -> Tuple[int, ...]:
    """Return the ids of all bodies in a physics client."""
    return tuple(pybullet.getBodyUniqueId(index, physicsClientId=physics_client_id)
                 for index in range(pybullet.getNumBodies(physicsClientId=physics_client_id)))


def load_urdf(urdf: str, physics_client_id: int, fixed: bool = False,
              pose: Transform = IDENTITY, visuals: bool = False,
              problems: Optional[Problems] = None, exact_hulls: bool = False) -> int:
    """Load the text of a URDF, in which all meshes have absolute paths; return its body's id.

    fixed: whether the root link never moves; pose: of the root link in the world; visuals: whether
    to load those as well, which only a window needs; those with a mesh that cannot be read are
    left out. problems: to which is added what is left out because a mesh of a collision shape
    cannot be read, which is an error without. exact_hulls: whether the convex hulls of meshes are
    as large as the meshes, and not 1 mm larger on each side.
    Raises SimulationError when PyBullet cannot load it, or would crash.
    """
    robot = ElementTree.fromstring(urdf)
    names.check_robot(robot)
    terrain = robot.find('link/collision/geometry/' + heightmaps.TAG)
    if terrain is not None:
        return _load_terrain(terrain, physics_client_id, pose)
    for link in robot.findall('link'):
        for collision in link.findall('collision'):
            _cache_meshes(link, collision, problems)
            if exact_hulls:
                _shrink(collision)
    if not visuals:
        for link in robot.findall('link'):
            for visual in link.findall('visual'):
                link.remove(visual)
        return _load(robot, physics_client_id, fixed, pose)
    with tempfile.TemporaryDirectory(prefix='img_recog_') as folder:
        _write_meshes(robot, folder)
        return _load(robot, physics_client_id, fixed, pose)


def _cache_meshes(link: ElementTree.Element, collision: ElementTree.Element,
                  problems: Optional[Problems]) -> None:
    """Replace the mesh of a collision shape by one from the cache."""
    try:
        for mesh in collision.findall('geometry/mesh'):
            mesh.set('filename', mesh_cache.cached(mesh.get('filename', ''),
                                                   urdf_visuals.submesh_of(mesh)))
    except SimulationError as error:
        if problems is None:
            raise
        problems.add(error.problem, error.advice)
        link.remove(collision)


def _shrink(collision: ElementTree.Element) -> None:
    """Take from a mesh on each side what PyBullet's margin adds to its convex hull."""
    mesh = collision.find('geometry/mesh')
    if mesh is None or collision.get('concave') == 'yes':
        return
    low, high = mesh_cache.bounds(mesh.get('filename', ''))
    scale = read_lengths('scale of a mesh', mesh.get('scale', '1 1 1'), 3)
    sizes = np.maximum((high - low) * np.abs(scale), 1e-9)
    factors = np.where(sizes > 4 * _MARGIN_M, 1 - 2 * _MARGIN_M / sizes, 1.0)
    mesh.set('scale', words(scale * factors))
    pose = origin_of(collision)
    middle = (low + high) / 2 * scale
    set_origin(collision, Transform(pose.rotation, pose.apply((1 - factors) * middle)))


def _load_terrain(element: ElementTree.Element, physics_client_id: int, pose: Transform) -> int:
    """Load a heightmap, the middle of whose heights is at `pose`."""
    heights, size = heightmaps.read(element)
    rows, columns = heights.shape
    client = {'physicsClientId': physics_client_id}
    # PyBullet means by rows the points along x
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_HEIGHTFIELD, meshScale=(size[0] / (columns - 1), size[1] / (rows - 1), 1),
        heightfieldData=heights.ravel().tolist(), numHeightfieldRows=columns,
        numHeightfieldColumns=rows, **client)
    # without a visual shape, PyBullet makes one of all triangles
    visual = pybullet.createVisualShape(pybullet.GEOM_SPHERE, radius=1e-4, **client)
    with _refusal('heightmap'):
        return pybullet.createMultiBody(0, shape, visual, pose.translation.tolist(),
                                        rotations.quaternion_of(pose.rotation), **client)


def _write_meshes(robot: ElementTree.Element, folder: str) -> None:
    """Replace the meshes of visuals by files that PyBullet can read; remove those without one."""
    for link in robot.findall('link'):
        for visual in link.findall('visual'):
            try:
                for mesh in visual.findall('geometry/mesh'):
                    mesh.set('filename', mesh_file.write(
                        mesh.get('filename', ''), tempfile.mkdtemp(dir=folder), materials=True,
                        submesh=urdf_visuals.submesh_of(mesh)))
            except MeshError:
                link.remove(visual)


def _load(robot: ElementTree.Element, physics_client_id: int, fixed: bool,
          pose: Transform) -> int:
    for link in robot.findall('link'):
        if link.find('visual') is None:
            # without any, PyBullet shows the collision shapes, and reads their meshes again
            link.append(ElementTree.fromstring(_NOTHING))
    orientation = rotations.quaternion_of(pose.rotation)
    with _file(ElementTree.tostring(robot, 'unicode')) as path, _refusal('URDF'):
        return pybullet.loadURDF(path, pose.translation.tolist(), orientation, useFixedBase=fixed,
                                 flags=_URDF_FLAGS, physicsClientId=physics_client_id)


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


def link_indices(body_id: int, physics_client_id: int) -> Dict[str, int]:
    """Return PyBullet's index of each link of a body by its name, -1 for the root link."""
    client = {'physicsClientId': physics_client_id}
    indices = {pybullet.getBodyInfo(body_id, **client)[0].decode(): -1}
    for index in range(pybullet.getNumJoints(body_id, **client)):
        indices[pybullet.getJointInfo(body_id, index, **client)[12].decode()] = index
    return indices
