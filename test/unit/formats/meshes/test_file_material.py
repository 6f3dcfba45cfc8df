"""Where the textures of mesh files are found."""
import os

import pytest

from img_recog.formats.meshes.file_material import find_texture, number_color, number_of

FILES = ('models/b/meshes/near.png', 'models/b/materials/textures/far.png',
         'models/b/materials/textures/both.png', 'models/b/meshes/both.png',
         'models/other/a.png', 'photos/me.jpg')


@pytest.mark.parametrize('name, found', [
    ('near.png', FILES[0]), ('far.png', FILES[1]), ('both.png', FILES[3]),
    ('../materials/textures/far.png', FILES[1]), ('file://near.png', FILES[0]),
    ('file://C:\\Users\\me\\far.png', FILES[1]), ('/home/me/near.png', FILES[0]),
    ('model://other/a.png', FILES[4]), ('package://b/materials/textures/far.png', FILES[1]),
    ('../../../../photos/me.jpg', FILES[5]), ('photos\\me.jpg', FILES[5]),
    ('none.png', 'models/b/meshes/none.png'), ('model://none/a.png', 'models/b/none/a.png'),
    (' ', '')])
def test_textures_are_found(tmp_path, name, found):
    for path in FILES:
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text('')
    mesh = str(tmp_path / 'models' / 'b' / 'meshes' / 'a.dae')
    assert find_texture(mesh, name) == (str(tmp_path / found) if found else '')
    assert not found or os.path.isfile(str(tmp_path / found)) == (found in FILES)


@pytest.mark.parametrize('number', [0, 1, 199, 200, 40000, 7999999])
def test_a_color_stands_for_a_number_rounded_or_not(number):
    for change in (int, round):
        assert number_of([change(255 * value) for value in number_color(number)]) == number
