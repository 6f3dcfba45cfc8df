"""Distances of rays to primitive shapes, checked point by point with another formula."""
import numpy as np
import pybullet
import pytest

from img_recog import rotations
from img_recog.simulation.physics.solids import Bundles, Solids

RAYS = 200
STEPS = np.linspace(0.0, 1.0, 1500)[1:-1]


@pytest.fixture
def client():
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


class Shape:
    def __init__(self, client, kind, size, position=(0, 0, 0), orientation=(0, 0, 0, 1)):
        self.kind, self.size = kind, size
        names = {pybullet.GEOM_BOX: ('halfExtents',), pybullet.GEOM_SPHERE: ('radius',),
                 pybullet.GEOM_CYLINDER: ('radius', 'height'), pybullet.GEOM_PLANE: ()}[kind]
        values = dict(zip(names, (size,) if kind == pybullet.GEOM_BOX else size))
        self.body = pybullet.createMultiBody(
            0, pybullet.createCollisionShape(kind, physicsClientId=client, **values),
            basePosition=position, baseOrientation=orientation, physicsClientId=client)
        self.move(client, position, orientation)

    def move(self, client, position, orientation=(0, 0, 0, 1)):
        pybullet.resetBasePositionAndOrientation(self.body, position, orientation,
                                                 physicsClientId=client)
        self.position, self.rotation = np.array(position), rotations.matrix(orientation)

    def contains(self, points, margin):
        """Return which points (n, 3) are inside, and farther than `margin` from the surface."""
        x, y, z = local = ((points - self.position) @ self.rotation).T
        if self.kind == pybullet.GEOM_BOX:
            return np.all(np.abs(local.T) < np.array(self.size) - margin, axis=1)
        if self.kind == pybullet.GEOM_PLANE:
            return z < -margin
        radius = self.size[0] - margin
        if self.kind == pybullet.GEOM_SPHERE:
            return x * x + y * y + z * z < radius * radius
        return (x * x + y * y < radius * radius) & (np.abs(z) < self.size[1] / 2 - margin)


def random_shape(client, random):
    kind = random.choice([pybullet.GEOM_BOX, pybullet.GEOM_SPHERE, pybullet.GEOM_CYLINDER])
    size = tuple(random.uniform(0.05, 0.8, {pybullet.GEOM_BOX: 3, pybullet.GEOM_SPHERE: 1,
                                            pybullet.GEOM_CYLINDER: 2}[kind]))
    turned = random.normal(size=4)
    return Shape(client, kind, size, random.uniform(-2.0, 2.0, 3), turned / np.linalg.norm(turned))


def bundle(start, directions, shortest=0.0, longest=np.inf):
    return Bundles(start[None], directions[None], np.array([shortest]), np.array([longest]))


def distances_of(solids, *rays, **limits):
    """Return the distances (rays,) of one bundle; there must be no shapes of other kinds."""
    found, has_others = solids.distances(bundle(*rays, **limits))
    assert not has_others
    return found[0]


def directions_into_the_shapes(start, random):
    directions = random.uniform(-2.0, 2.0, (RAYS, 3)) - start
    return directions / np.linalg.norm(directions, axis=1)[:, None]


@pytest.mark.parametrize('seed', range(4))
def test_rays_end_where_they_enter_the_first_shape_or_leave_that_around_them(client, seed):
    random = np.random.RandomState(seed)
    shapes = [random_shape(client, random) for _ in range(8)]
    if seed % 3 == 0:
        shapes.append(Shape(client, pybullet.GEOM_PLANE, ()))
    start = random.uniform(-1.0, 1.0, 3) + (0, 0, 1)
    directions = directions_into_the_shapes(start, random)
    around = [shape for shape in shapes if shape.contains(start[None], 0)[0]]
    distances = distances_of(Solids(client), start, directions)
    hits = np.isfinite(distances)
    assert np.count_nonzero(hits) > 10 and distances.min() > 0
    for direction, distance in zip(directions, distances):
        until = min(distance, 6.0)
        before = start + direction * (until * STEPS)[:, None]
        for shape in shapes:
            if shape not in around:
                assert not shape.contains(before, 1e-6).any()
            else:
                assert shape.contains(before, -1e-6).all()
        if distance < 6.0:
            end = (start + direction * distance)[None]
            assert any(shape.contains(end, -1e-6)[0] and not shape.contains(end, 1e-6)[0]
                       for shape in shapes)


@pytest.mark.parametrize('seed', range(3))
def test_what_is_within_a_range_is_found(client, seed):
    random = np.random.RandomState(seed)
    for _ in range(12):
        random_shape(client, random)
    solids, start = Solids(client), random.uniform(-4.0, 4.0, 3)
    directions = directions_into_the_shapes(start, random)
    every = distances_of(solids, start, directions)
    for longest in (0.5, 1.0, 2.0, 4.0):
        found = distances_of(solids, start, directions, longest=longest)
        assert np.array_equal(found[every <= longest], every[every <= longest])
        assert np.all(found[every > longest] > longest)


@pytest.mark.parametrize('seed', range(4))
def test_distances_are_those_of_pybullet(client, seed):
    random = np.random.RandomState(seed)
    for _ in range(6):
        random_shape(client, random)
    start = np.array([0.0, 0.0, 3.5])
    directions = directions_into_the_shapes(start, random)
    distances = distances_of(Solids(client), start, directions)
    hits = pybullet.rayTestBatch([start.tolist()] * RAYS, (start + 8 * directions).tolist(),
                                 physicsClientId=client)
    theirs = np.array([8 * hit[2] if hit[0] >= 0 else np.inf for hit in hits])
    both = np.isfinite(distances) & np.isfinite(theirs)
    assert np.count_nonzero(both) > 10
    # those that graze a shape differ
    close = np.count_nonzero(np.abs(distances[both] - theirs[both]) < 0.005)
    assert close + np.count_nonzero(np.isinf(distances) & np.isinf(theirs)) > 0.97 * RAYS


BOX, BALL = (pybullet.GEOM_BOX, (0.5, 0.6, 0.7)), (pybullet.GEOM_SPHERE, (0.5,))
CYLINDER, FLOOR = (pybullet.GEOM_CYLINDER, (0.5, 2.0)), (pybullet.GEOM_PLANE, ())


@pytest.mark.parametrize('shape, start, direction, shortest, expected', [
    # along the axes, at the sides and past them
    (BOX, (-2, 0, 0.25), (1, 0, 0), 0, 1.5), (BOX, (-2, 0, 0.25), (0, 1, 0), 0, np.inf),
    (BOX, (-2, 0, 0.25), (-1, 0, 0), 0, np.inf), (FLOOR, (0, 0, 0.25), (0, 0, -1), 0, 0.25),
    (FLOOR, (0, 0, -1), (0, 0, 1), 0, 1), (FLOOR, (0, 0, 0.25), (1, 0, 0), 0, np.inf),
    (CYLINDER, (0.3, 0.3, 3), (0, 0, -1), 0, 2), (CYLINDER, (0.5, 0.3, 3), (0, 0, -1), 0, np.inf),
    # a ray begins at the shortest range
    *((shape, (start, 0, 0), (1, 0, 0), shortest, expected) for shape in (BOX, BALL, CYLINDER)
      for start, shortest, expected in ((0, 0.12, 0.5), (0, 0.6, np.inf), (-1, 0.12, 0.5),
                                        (-1, 0.6, 1.5), (-1, 1.6, np.inf)))])
def test_a_ray_to_one_shape(client, shape, start, direction, shortest, expected):
    Shape(client, *shape)
    found = distances_of(Solids(client), np.array(start, float), np.array([direction], float),
                         shortest=shortest)
    assert found.tolist() == pytest.approx([expected])


def test_what_is_moved_added_and_removed_is_noticed(client):
    start, rays = np.zeros(3), np.array([[1.0, 0.0, 0.0]])
    solids = Solids(client)
    assert distances_of(solids, start, rays).tolist() == [np.inf]
    ball = Shape(client, pybullet.GEOM_SPHERE, (0.5,), (2.0, 0, 0))
    assert distances_of(solids, start, rays).tolist() == [1.5]
    ball.move(client, (3.0, 0, 0))
    assert distances_of(solids, start, rays).tolist() == [2.5]
    pybullet.removeBody(ball.body, physicsClientId=client)
    assert distances_of(solids, start, rays).tolist() == [np.inf]


def test_links_that_move(client):
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(0.5, 0.1, 0.1),
                                          collisionFramePosition=(0.5, 0, 0),
                                          physicsClientId=client)
    body = pybullet.createMultiBody(
        0, basePosition=(0, 2, 0), linkMasses=[1], linkCollisionShapeIndices=[shape],
        linkVisualShapeIndices=[-1], linkPositions=[(0, 0, 0)], linkOrientations=[(0, 0, 0, 1)],
        linkInertialFramePositions=[(0.2, 0, 0)], linkInertialFrameOrientations=[(0, 0, 0, 1)],
        linkParentIndices=[0], linkJointTypes=[pybullet.JOINT_REVOLUTE],
        linkJointAxis=[(0, 0, 1)], physicsClientId=client)
    start, rays = np.zeros(3), np.array([[0.0, 1.0, 0.0]])
    solids = Solids(client)
    assert distances_of(solids, start, rays).tolist() == pytest.approx([1.9])
    pybullet.resetJointState(body, 0, -np.pi / 2, physicsClientId=client)
    assert distances_of(solids, start, rays).tolist() == pytest.approx([1.0])


@pytest.mark.parametrize('kind, values', [
    (pybullet.GEOM_CAPSULE, {'radius': 0.2, 'height': 1.0}),
    (pybullet.GEOM_PLANE, {'planeNormal': (1, 0, 0)}),
    (pybullet.GEOM_MESH, {'vertices': [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]})])
def test_other_shapes_are_left_to_pybullet(client, kind, values):
    solids = Solids(client)
    other = pybullet.createMultiBody(0, pybullet.createCollisionShape(
        kind, physicsClientId=client, **values), physicsClientId=client)
    start, rays = np.zeros(3), np.array([[1.0, 0.0, 0.0]])
    Shape(client, pybullet.GEOM_SPHERE, (0.5,), (2.0, 0, 0))
    found, has_others = solids.distances(bundle(start, rays))
    assert found.tolist() == [[1.5]] and has_others
    pybullet.removeBody(other, physicsClientId=client)
    assert distances_of(solids, start, rays).tolist() == [1.5]
