"""OBJ files of Wavefront and their files of materials."""
import numpy as np
import pytest

from img_recog.formats.meshes import mesh_file
from img_recog.model import WHITE, Material

OBJ = 'mtllib {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n'


def read(folder, mtl=None, obj=OBJ.format('a.mtl')):
    """Return the only part of an OBJ with a file of materials."""
    (folder / 'a.obj').write_text(obj)
    if mtl is not None:
        (folder / 'a.mtl').write_text(mtl)
    part, = mesh_file.read(str(folder / 'a.obj'))
    return part


@pytest.mark.parametrize('obj', [
    OBJ.format('a.mtl'), OBJ.format('a.mtl').replace('usemtl m\n', ''), OBJ[10:]])
def test_texture_coordinates_need_no_material(tmp_path, obj):
    part = read(tmp_path, obj=obj)
    assert part.uvs == pytest.approx(part.positions[:, :, :2])
    assert (part.material, part.has_material) == (WHITE, False)


@pytest.mark.parametrize('mtl, color', [
    ('', (0, 0, 0, 1)), ('Kd 0.1 0.2 0.3', (0.1, 0.2, 0.3, 1)), ('\tKd\t0.5', (0.5, 0.5, 0.5, 1)),
    ('Kd 0 0 1\nd 0.5', (0, 0, 1, 0.5)), ('Kd 0 0 1\nTr 0.25', (0, 0, 1, 0.75)),
    ('d -halo 0.5', (0, 0, 0, 0.5)), ('Kd 0,5 0 0\nd 0.5', (0, 0, 0, 0.5)),
    ('Kd spectral a.rfl 1', (0, 0, 0, 1)), ('# a\n\nillum\nKd 0.1 0.2 0.3', (0.1, 0.2, 0.3, 1)),
    ('Kd 0 0 1\nd 2', (0, 0, 1, 1)), ('Kd 0 0 1\nd -1', (0, 0, 1, 0)),
    ('Kd 0 0 1\nTr 0.25 0.5', (0, 0, 1, 0.5))])
def test_colors(tmp_path, mtl, color):
    part = read(tmp_path, 'newmtl other\nKd 1 1 1\nnewmtl m\n{}\nnewmtl last\nd 0'.format(mtl))
    assert part.material.color == pytest.approx(color) and part.has_material


def test_all_colors_of_a_material_are_read(tmp_path):
    part = read(tmp_path, 'newmtl m\nKa 0 0.5 0\nKd 0 0 0.5\nKs 0.4 0.5 0.6\nKe 0.1\nNs 20\n'
                          'Ks xyz 1 2 3\n')
    assert part.material == Material((0, 0, 0.5, 1), ambient=(0, 0.5, 0), shininess=20,
                                     specular=(0.4, 0.5, 0.6), emissive=(0.1, 0.1, 0.1))
    # what is not stated is dark, in Gazebo too
    assert read(tmp_path, 'newmtl m\nKd 1 0 0\n').material.ambient == (0, 0, 0)


@pytest.mark.parametrize('end', ['\n', '\r\n'])
@pytest.mark.parametrize('first', ['1', '-3'])
def test_a_line_may_go_on_in_the_next_one(tmp_path, first, end):
    obj = OBJ.replace('f 1/1', 'f {}/1 \\'.format(first)).replace('\n', end)
    obj = obj.replace('\\ 2/2', '\\' + end + '2/2 ')
    assert '\\' + end in obj
    assert read(tmp_path, 'newmtl m\nKd 1 0 0', obj).positions.tolist() == [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


@pytest.mark.parametrize('mtl, name', [
    ('map_Kd a b.png', 'a b.png'), ('map_Kd -s 2 2 1 -clamp on a.png', 'a.png'),
    ('map_kd\ta.png', 'a.png'), ('map_Kd a -s 1 b.png', 'a -s 1 b.png'),
    ('map_Bump bump.png\nmap_Ks b.png', '')])
def test_textures(tmp_path, mtl, name):
    part = read(tmp_path, 'newmtl m\nKd 1 0 0\n' + mtl)
    assert part.material.texture == (str(tmp_path / name) if name else '')
    assert part.material.color == (1, 0, 0, 1)


@pytest.mark.parametrize('names', ['a.mtl', 'none.mtl a.mtl', 'none.mtl\nmtllib  a.mtl \r'])
def test_all_files_of_materials_are_read(tmp_path, names):
    assert read(tmp_path, 'newmtl m\nKd 1 0 0', OBJ.format(names)).material.color == (1, 0, 0, 1)


def test_parts_have_their_materials(tmp_path):
    (tmp_path / 'a.mtl').write_text(''.join(
        'newmtl m{}\nKd {} 0 0\n'.format(number, number / 300) for number in range(300)))
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n' + ''.join(
        'usemtl m{}\nf 1 2 3\n'.format(number) for number in range(300)))
    parts = mesh_file.read(str(tmp_path / 'a.obj'))
    assert sorted(part.material.color[0] for part in parts) == pytest.approx(np.arange(300) / 300)


def test_parts_have_the_name_of_the_object_or_group_before_them(tmp_path):
    (tmp_path / 'a.mtl').write_text('newmtl m\nKd 1 0 0\n')
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no one\n'
                                    'f 1 2 3\nusemtl m\nf 1 2 3\ng two  words\nf 1 2 3\n'
                                    'usemtl none\no\nf 3 2 1\n')
    parts = mesh_file.read(str(tmp_path / 'a.obj'))
    assert sorted((part.name, part.has_material, len(part.positions)) for part in parts) == [
        ('', False, 2), ('one', False, 1), ('one', True, 1), ('two words', True, 1)]


@pytest.mark.parametrize('face', [
    'f 1/2/1 2/3/2 4/1/1', 'f -4/-2/-2 -3/-1/-1 -1/-3/-2', '\n\tf -4/-2/1 2/-1/-1 -1/1/-2'])
def test_indices_may_count_from_the_last_one(tmp_path, face):
    part = read(tmp_path, obj='v 0 0 0\nv 1 0 0\nv 5 5 5\nv 0 1 0\nvt 0 0.5\nvt 0.5 0\nvt 1 1\n'
                'vn 0.6 0 0.8\nvn 0 -0.6 0.8\n' + face + '\n')
    assert part.positions.tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    assert part.uvs.tolist() == [[[0.5, 0], [1, 1], [0, 0.5]]]
    assert part.normals == pytest.approx(np.array([[[0.6, 0, 0.8], [0, -0.6, 0.8],
                                                    [0.6, 0, 0.8]]]))


def test_a_corner_may_have_a_normal_without_a_texture_coordinate(tmp_path):
    part = read(tmp_path, obj='v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\n'
                'f -3//-1 -2//-1 -1//-1\n')
    assert part.normals == pytest.approx(np.broadcast_to((0.6, 0, 0.8), (1, 3, 3)))
    assert part.uvs.tolist() == [[[0, 0]] * 3]


def test_bytes_that_are_not_utf_8_do_not_matter(tmp_path):
    obj = (b'mtllib caf\xe9.mtl a.mtl\n# caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\no caf\xe9\n'
           b'usemtl m\n\tf 1 2 3\n')
    (tmp_path / 'a.obj').write_bytes(obj)
    (tmp_path / 'a.mtl').write_bytes(b'# caf\xe9\nnewmtl m\nKd 1 0 0\n')
    part, = mesh_file.read(str(tmp_path / 'a.obj'))
    assert (part.name, part.material.color) == ('caf\ufffd', (1, 0, 0, 1))


def test_the_name_of_a_file_of_materials_may_have_a_space(tmp_path):
    (tmp_path / 'my a.mtl').write_text('newmtl m\nKd 1 0 0')
    assert read(tmp_path, obj=OBJ.format('my a.mtl')).material.color == (1, 0, 0, 1)
    assert mesh_file.material_files(str(tmp_path / 'a.obj')) == [str(tmp_path / 'my a.mtl')]
    (tmp_path / 'a.stl').write_text('mtllib a.mtl\n')
    assert mesh_file.material_files(str(tmp_path / 'a.stl')) == []


def test_a_file_of_materials_is_read_up_to_16_mebibytes(tmp_path):
    end = '\nnewmtl m\nKd 1 0 0.2'
    mtl = '#'.ljust((1 << 24) - len(end), 'x') + end + '5'
    assert read(tmp_path, mtl).material.color == (1, 0, 0.2, 1)
