"""The triangles of shapes."""
import numpy as np
import pytest

from img_recog.formats.meshes.mesh_file import MeshError
from img_recog.model import BOX, CYLINDER, MESH, PLANE, SPHERE, WHITE, Shape, Submesh
from img_recog.rendering.triangles import of_shape

OBJ = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'


def area_and_volume(part):
    """Return the area of the triangles, and the volume that they enclose if wound outward."""
    a, b, c = part.positions.transpose(1, 0, 2)
    crosses = np.cross(b - a, c - a)
    return np.linalg.norm(crosses, axis=1).sum() / 2, np.einsum('ij,ij->', a, crosses) / 6


@pytest.mark.parametrize('shape, area, volume', [
    (Shape(BOX, (1.0, 2.0, 3.0)), 22.0, 6.0),
    (Shape(CYLINDER, (0.5, 2.0)), 2.5 * np.pi, 0.5 * np.pi),
    (Shape(SPHERE, (0.5,)), np.pi, np.pi / 6),
    (Shape(PLANE, (4.0, 2.0)), 8.0, 0.0)])
def test_primitive_shapes(shape, area, volume):
    part, = of_shape(shape)
    assert part.material == WHITE
    got = area_and_volume(part)
    assert got[0] == pytest.approx(area, rel=0.01)
    assert got[1] == pytest.approx(volume, rel=0.02)
    assert np.linalg.norm(part.normals, axis=2) == pytest.approx(
        np.ones(part.normals.shape[:2]), abs=1e-6)
    if shape.kind != PLANE:     # they point away from the center
        assert np.all(np.einsum('ijk,ijk->ij', part.positions, part.normals) > 0)
        a, b, c = part.positions.transpose(1, 0, 2)
        outward = np.einsum('ij,ij->i', np.cross(b - a, c - a), a)
        # no triangle is wound the other way; those at the poles of a sphere have no area
        assert outward.min() > -1e-12 and np.mean(outward > 1e-6) > 0.9
    triangles = {BOX: 12, CYLINDER: 4 * 48, SPHERE: 2 * 48 * 24, PLANE: 2}
    assert len(part.positions) == triangles[shape.kind]
    assert part.uvs.min() >= -1e-9 and part.uvs.max() <= 1 + 1e-9


def test_a_plane_faces_upward():
    part, = of_shape(Shape(PLANE, (4.0, 2.0)))
    assert np.all(part.normals == (0, 0, 1)) and np.all(part.positions[:, :, 2] == 0)
    lower_left = part.positions[np.all(part.uvs == 0, axis=2)]
    assert np.all(lower_left == (-2, -1, 0)) and len(lower_left)


def test_textures_are_upright_on_the_sides_of_a_box():
    part, = of_shape(Shape(BOX, (1.0, 1.0, 1.0)))
    sides = np.abs(part.normals[:, :, 2]) < 0.5
    assert part.uvs[sides][:, 1] == pytest.approx(part.positions[sides][:, 2] + 0.5)
    for normal, right in (((1, 0), (0, 1)), ((-1, 0), (0, -1)), ((0, 1), (-1, 0)),
                          ((0, -1), (1, 0))):       # seen from outside, u is to the right
        face = np.all(part.normals[:, :, :2] == normal, axis=2)
        assert part.uvs[face][:, 0] == pytest.approx(
            part.positions[face][:, :2] @ right + 0.5), normal


@pytest.mark.parametrize('side, right, up', [(1, (0, -1), (1, 0)), (-1, (0, -1), (-1, 0))])
def test_textures_on_top_of_a_box_and_below_are_those_of_gazebo(side, right, up):
    part, = of_shape(Shape(BOX, (1.0, 1.0, 1.0)))
    face = np.all(part.normals == (0, 0, side), axis=2)
    assert part.uvs[face] == pytest.approx(
        np.column_stack([part.positions[face][:, :2] @ axis + 0.5 for axis in (right, up)]))


def test_a_texture_on_a_cylinder_is_upside_down_like_in_gazebo():
    part, = of_shape(Shape(CYLINDER, (1.0, 2.0)))
    side = np.abs(part.normals[:, :, 2]) < 0.5
    x, y, z = part.positions[side].T
    assert part.uvs[side][:, 1] == pytest.approx((1 - z) / 2)
    u = part.uvs[side][:, 0]        # clockwise from the y axis, seen from above
    assert np.sin(2 * np.pi * u) == pytest.approx(x) and np.cos(2 * np.pi * u) == pytest.approx(y)
    caps = ~side & (np.hypot(*part.positions[..., :2].transpose(2, 0, 1)) > 0.5)
    assert part.uvs[caps][:, 1].tolist() == (part.positions[caps][:, 2] < 0).tolist()
    assert np.sin(2 * np.pi * part.uvs[caps][:, 0]) == pytest.approx(part.positions[caps][:, 0])


def test_the_poles_of_a_sphere_are_on_the_y_axis_like_in_gazebo():
    part, = of_shape(Shape(SPHERE, (1.0,)))
    x, y, z = part.positions.reshape(-1, 3).T
    u, v = part.uvs.reshape(-1, 2).T
    assert np.sin(np.pi * (v - 0.5)) == pytest.approx(y)
    inner = np.abs(y) < 0.99
    assert np.arctan2(x, z)[inner] == pytest.approx(
        np.arctan2(np.sin(2 * np.pi * u), np.cos(2 * np.pi * u))[inner], abs=1e-9)


def test_a_submesh_may_be_moved_to_the_middle(tmp_path):
    (tmp_path / 'a.obj').write_text('o a\n' + OBJ[:-8] + 'o b\nf 2 3 4\n')
    path = str(tmp_path / 'a.obj')
    part, = of_shape(Shape(MESH, (2.0, 1.0, 1.0), path, Submesh('b')))
    assert part.positions.tolist() == [[[2, 0, 0], [0, 1, 0], [0, 0, 1]]] and part.name == 'b'
    part, = of_shape(Shape(MESH, (2.0, 1.0, 1.0), path, Submesh('b', is_centered=True)))
    assert part.positions.tolist() == [[[1, -.5, -.5], [-1, .5, -.5], [-1, -.5, .5]]]
    with pytest.raises(MeshError, match='has no submesh c; its submeshes are: a, b'):
        of_shape(Shape(MESH, (1.0, 1.0, 1.0), path, Submesh('c')))
    (tmp_path / 'a.obj').write_text(OBJ)
    with pytest.raises(MeshError, match='its submeshes are: none$'):
        of_shape(Shape(MESH, (1.0, 1.0, 1.0), path, Submesh('c')))


def test_obj_without_a_material_is_grey(tmp_path):
    (tmp_path / 'a.obj').write_text(OBJ)
    part, = of_shape(Shape(MESH, (2.0, 2.0, 2.0), str(tmp_path / 'a.obj')))
    assert part.positions.shape == (4, 3, 3) and part.positions.max() == 2
    assert area_and_volume(part)[1] == pytest.approx(8 / 6)


def test_normals_of_a_scaled_mesh_stay_upright_on_it(tmp_path):
    (tmp_path / 'a.obj').write_text(OBJ)
    part, = of_shape(Shape(MESH, (3.0, 1.0, 0.5), str(tmp_path / 'a.obj')))
    assert np.linalg.norm(part.normals, axis=2) == pytest.approx(np.ones((4, 3)))
    a, b, c = part.positions.transpose(1, 0, 2)
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert part.normals == pytest.approx(np.stack([flat] * 3, axis=1), abs=1e-6)


@pytest.mark.parametrize('shape', [
    Shape(BOX, (0.0, 1.0, 0.0)), Shape(CYLINDER, (0.0, 0.0)), Shape(SPHERE, (0.0,))])
def test_a_size_of_zero_gives_finite_numbers(shape):
    part, = of_shape(shape)
    assert all(np.isfinite(values).all() for values in part[:3])


def test_a_scale_of_zero_gives_finite_numbers(tmp_path):
    (tmp_path / 'a.obj').write_text(OBJ)
    part, = of_shape(Shape(MESH, (1.0, 0.0, 1.0), str(tmp_path / 'a.obj')))
    assert np.isfinite(part.normals).all() and np.ptp(part.positions[..., 1]) == 0
