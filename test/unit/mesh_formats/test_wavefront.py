"""OBJ files of Wavefront and their files of materials."""
import numpy as np
import pytest

from img_recog import mesh_file
from img_recog.visuals import GREY

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
    assert (part.color, part.texture, part.has_material) == (GREY, '', False)


@pytest.mark.parametrize('mtl, color', [
    ('', GREY), ('Kd 0.1 0.2 0.3', (0.1, 0.2, 0.3, 1)), ('\tKd\t0.5', (0.5, 0.5, 0.5, 1)),
    ('Kd 0 0 1\nd 0.5', (0, 0, 1, 0.5)), ('Kd 0 0 1\nTr 0.25', (0, 0, 1, 0.75)),
    ('d -halo 0.5', (0.7, 0.7, 0.7, 0.5)), ('Kd 0,5 0 0\nd 0.5', (0.7, 0.7, 0.7, 0.5)),
    ('Kd spectral a.rfl 1', GREY)])
def test_colors(tmp_path, mtl, color):
    part = read(tmp_path, 'newmtl other\nKd 1 1 1\nnewmtl m\n{}\nnewmtl last\nd 0'.format(mtl))
    assert part.color == pytest.approx(color) and part.has_material


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
    ('map_kd\ta.png', 'a.png'), ('map_Bump bump.png\nmap_Ks b.png', '')])
def test_textures(tmp_path, mtl, name):
    part = read(tmp_path, 'newmtl m\nKd 1 0 0\n' + mtl)
    assert part.texture == (str(tmp_path / name) if name else '')
    assert part.color == (1, 0, 0, 1)


@pytest.mark.parametrize('names', ['a.mtl', 'none.mtl a.mtl', 'none.mtl\nmtllib  a.mtl \r'])
def test_all_files_of_materials_are_read(tmp_path, names):
    assert read(tmp_path, 'newmtl m\nKd 1 0 0', OBJ.format(names)).color == (1, 0, 0, 1)


def test_parts_have_their_materials(tmp_path):
    (tmp_path / 'a.mtl').write_text(''.join(
        'newmtl m{}\nKd {} 0 0\n'.format(number, number / 300) for number in range(300)))
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n' + ''.join(
        'usemtl m{}\nf 1 2 3\n'.format(number) for number in range(300)))
    parts = mesh_file.read(str(tmp_path / 'a.obj'))
    assert sorted(part.color[0] for part in parts) == pytest.approx(np.arange(300) / 300)


def test_parts_have_the_name_of_the_object_or_group_before_them(tmp_path):
    (tmp_path / 'a.mtl').write_text('newmtl m\nKd 1 0 0\n')
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no one\n'
                                    'f 1 2 3\nusemtl m\nf 1 2 3\ng two  words\nf 1 2 3\n')
    parts = mesh_file.read(str(tmp_path / 'a.obj'))
    assert sorted((part.name, part.has_material) for part in parts) == [
        ('', False), ('one', False), ('one', True), ('two words', True)]
