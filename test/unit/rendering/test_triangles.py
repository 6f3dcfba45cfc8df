"""The triangles of shapes, and of mesh files."""
import numpy as np
import pytest
from PIL import Image

from img_recog.rendering import triangles
from img_recog.rendering.triangles import GREY, MeshError, of_shape
from img_recog.visuals import BOX, CYLINDER, MESH, PLANE, SPHERE, Shape
from img_recog_testing import bombs

COLLADA = '''<COLLADA version="1.4.1" xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse>
<color>0.2 0.4 0.6 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="a" count="9">0 0 0 100 0 0 0 0 100</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'''
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
    assert part.color == GREY and part.texture is None
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


def test_collada_in_its_unit_and_without_its_up_axis(tmp_path):
    (tmp_path / 'a.dae').write_text(COLLADA)
    part, = of_shape(Shape(MESH, (1.0, 2.0, 3.0), str(tmp_path / 'a.dae')))
    assert part.positions.reshape(-1, 3).max(axis=0) == pytest.approx([2.54, 0, 7.62])
    assert part.color == pytest.approx((0.2, 0.4, 0.6, 1.0), abs=0.005)
    assert np.abs(part.normals[0, 0]) == pytest.approx([0, 1, 0])


def test_obj_with_a_texture(tmp_path):
    Image.new('RGB', (2, 2), (10, 20, 30)).save(str(tmp_path / 'a.png'))
    (tmp_path / 'a.mtl').write_text('newmtl m\nKd 1 1 1\nmap_Kd a.png\n')
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n'
                                    'vt 0 1\nusemtl m\nf 1/1 2/2 3/3\n')
    part, = of_shape(Shape(MESH, (1.0, 1.0, 1.0), str(tmp_path / 'a.obj')))
    assert part.texture is not None and part.texture[0, 0].tolist() == [10, 20, 30]
    assert part.uvs[0].tolist() == [[0, 0], [1, 0], [0, 1]]


def test_obj_without_a_material_is_grey(tmp_path):
    (tmp_path / 'a.obj').write_text(OBJ)
    part, = of_shape(Shape(MESH, (2.0, 2.0, 2.0), str(tmp_path / 'a.obj')))
    assert part.positions.shape == (4, 3, 3) and part.positions.max() == 2
    assert area_and_volume(part)[1] == pytest.approx(8 / 6)


@pytest.mark.parametrize('shape', [
    Shape(BOX, (0.0, 1.0, 0.0)), Shape(CYLINDER, (0.0, 0.0)), Shape(SPHERE, (0.0,))])
def test_a_size_of_zero_gives_finite_numbers(shape):
    part, = of_shape(shape)
    assert all(np.isfinite(values).all() for values in part[:3])


def test_a_scale_of_zero_gives_finite_numbers(tmp_path):
    (tmp_path / 'a.obj').write_text(OBJ)
    part, = of_shape(Shape(MESH, (1.0, 0.0, 1.0), str(tmp_path / 'a.obj')))
    assert np.isfinite(part.normals).all() and np.ptp(part.positions[..., 1]) == 0


TEXTURED = ('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n'
            'f 1/1 2/2 3/3\n')


def textured(folder, image):
    """Return the first triangles of an OBJ that names the texture `image`."""
    (folder / 'meshes').mkdir(exist_ok=True)
    (folder / 'meshes' / 'a.mtl').write_text('newmtl m\nKd 0.2 0.4 0.6\nmap_Kd {}\n'.format(
        image))
    (folder / 'meshes' / 'a.obj').write_text(TEXTURED)
    part, = triangles.read(str(folder / 'meshes' / 'a.obj'))
    return part


def test_textures_are_found_where_gazebo_looks_for_them(tmp_path):
    (tmp_path / 'materials' / 'textures').mkdir(parents=True)
    Image.new('RGB', (2, 2), (10, 20, 30)).save(str(tmp_path / 'materials' / 'textures' / 'a.png'))
    part = textured(tmp_path, 'a.png')
    assert part.problem == '' and part.texture[0, 0].tolist() == [10, 20, 30]


def test_a_texture_that_is_missing_is_named_and_the_mesh_is_drawn(tmp_path):
    part = textured(tmp_path, 'a.png')
    assert part.problem == ('cannot read all of the mesh {}: its texture a.png: No such file or '
                            'directory'.format(tmp_path / 'meshes' / 'a.obj'))
    assert part.texture is None and part.color == pytest.approx((0.2, 0.4, 0.6, 1.0), abs=0.005)


@pytest.mark.parametrize('share', [0.0, 0.02, 0.5, 0.95])
@pytest.mark.parametrize('suffix', ['png', 'jpg'])
def test_a_texture_that_is_truncated_is_named_and_the_mesh_is_drawn(tmp_path, suffix, share):
    noise = np.random.RandomState(0).randint(0, 255, (64, 64, 3)).astype(np.uint8)
    Image.fromarray(noise).save(str(tmp_path / ('whole.' + suffix)))
    content = (tmp_path / ('whole.' + suffix)).read_bytes()
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / ('a.' + suffix)).write_bytes(content[:int(share * len(content))])
    part = textured(tmp_path, 'a.' + suffix)
    assert 'its texture ' in part.problem and '\n' not in part.problem
    assert part.texture is None and len(part.positions) == 1


def test_a_texture_of_too_many_pixels_is_named_and_not_decoded(tmp_path):
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'a.png').write_bytes(bombs.png())
    part = textured(tmp_path, 'a.png')
    assert '20000x20000 pixels are more than 50000000' in part.problem and part.texture is None


@pytest.mark.parametrize('number', ['nan', 'inf', '1e300', '-1e10'])
def test_a_mesh_with_a_coordinate_that_cannot_be_drawn_is_refused(tmp_path, number):
    (tmp_path / 'a.obj').write_text(OBJ.replace('v 1 0 0', 'v {} 0 0'.format(number)))
    with pytest.raises(MeshError, match='it has a coordinate of more than 1e'):
        triangles.read(str(tmp_path / 'a.obj'))


def test_a_mesh_of_too_many_triangles_is_refused(tmp_path, monkeypatch):
    (tmp_path / 'a.obj').write_text(OBJ)
    monkeypatch.setattr(triangles, '_MAX_TRIANGLES', 3)
    with pytest.raises(MeshError, match='it has 4 triangles, allowed are 1 to 3;'):
        triangles.read(str(tmp_path / 'a.obj'))
    with open(str(tmp_path / 'b.stl'), 'wb') as file:       # of 10 million triangles
        file.truncate(84 + 50 * 10000000)
    with pytest.raises(MeshError, match='it has 500000084 bytes, more than 268435456;'):
        triangles.read(str(tmp_path / 'b.stl'))


@pytest.mark.parametrize('name, content', [
    ('a.dae', COLLADA[:300]), ('a.stl', 'solid a\n'), ('a.obj', ''), ('a.stl', ''),
    ('a.xyz', '1 2 3'), ('none.stl', None)])
def test_a_mesh_that_cannot_be_read_is_named(tmp_path, name, content):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(MeshError) as error:
        triangles.read(str(path))
    assert str(error.value).startswith('cannot read the mesh {}: '.format(path))
    assert '\n' not in str(error.value)
