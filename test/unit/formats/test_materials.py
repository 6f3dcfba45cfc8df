"""The materials of SDF visuals."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import materials
from img_recog.model import Material
from img_recog.report import NOT_FOUND, Report

SCRIPT = '''
// material commented { technique { pass { diffuse 1 1 1 } } }
material first
{ technique { pass { ambient 0 1 0 1
  diffuse 0.1 0.2 0.3 0.5 } } }
/* material first { } */
material course : first
{
  technique { pass { texture_unit { texture course.png } } }
}
material shiny { technique { pass { diffuse 0.5 0.25 0.5
  specular 0.1 .2 .3 1 12.5 emissive 0 0 0 } } }
material bright { technique { pass { lighting off diffuse 1 0 0 } } }
material pond { technique { pass { diffuse 0.1 0.4 0.3 fragment_program_ref PondFS { }
  texture_unit normalMap { texture waves.png } texture_unit { texture pond_normals.png }
  texture_unit { texture course.png } } } }
material broken { technique { pass { diffuse 1.2.3 0 0 scale 2 3 } } }
material glowing { technique { pass { ambient 0.5 0.5 0.25 0.4 emissive 0.7 0 0 } } }
material short { technique { pass { diffuse 0.9 0.8 ambient 0.1 0.2 0.3 emissive 0.5 0.5 } } }
material bare { technique { pass { texture_unit { scale 0.5 texture course.png } } } }
material small { technique { pass { texture_unit { scale 0 0 texture course.png } } } }
material far : base { technique { pass { texture_unit { scale 0.1 .25 texture "course.png" } } } }
abstract material "base" { technique { pass { diffuse 1 1 1 1 } } }
material nearer : far {}
material lost { technique { pass { texture_unit { texture lost.png } diffuse .5 .5 .5 } } }
'''


def read(inside, find=lambda uri: None, transparency=''):
    visual = ElementTree.fromstring('<visual name="v">{}{}</visual>'.format(inside, transparency))
    report = Report()
    return materials.of_sdf(visual, find, report), ''.join(report.of(NOT_FOUND))


def script(name, *uris):
    return '<material><script>{}<name>{}</name></script></material>'.format(
        ''.join('<uri>{}</uri>'.format(uri) for uri in uris), name)


@pytest.fixture
def folder(tmp_path):
    """A model's folder of materials, and the function that finds model://m there."""
    for name in ('scripts', 'textures'):
        (tmp_path / name).mkdir()
    (tmp_path / 'scripts' / 'a.material').write_text(SCRIPT)
    (tmp_path / 'textures' / 'course.png').write_text('')
    return tmp_path


@pytest.mark.parametrize('uris', [
    ('model://m/scripts', 'model://m/textures'), ('model://m/scripts/a.material',),
    ('model://m/none', 'model://m/scripts')])
def test_a_script_and_its_texture(folder, uris):
    def find(uri):
        path = folder / uri[len('model://m/'):]
        return str(path) if path.exists() else None
    texture = str(folder / 'textures' / 'course.png')
    white = Material(ambient=(1, 1, 1))
    first = Material((0.1, 0.2, 0.3, 0.5), ambient=(0, 1, 0))
    for name, expected in (
            ('first', first), ('course', first._replace(texture=texture)), ('broken', white),
            ('shiny', white._replace(color=(0.5, 0.25, 0.5, 1), specular=(0.1, 0.2, 0.3),
                                     shininess=12.5)),
            ('glowing', Material(ambient=(0.5, 0.5, 0.25), emissive=(0.7, 0, 0))),
            ('bright', Material((0, 0, 0, 1), ambient=(0, 0, 0), emissive=(1, 1, 1))),
            ('short', Material(ambient=(0.1, 0.2, 0.3))),
            ('bare', white._replace(texture=texture, scale=(0.5, 1))),
            ('small', white._replace(texture=texture)),
            ('far', white._replace(texture=texture, scale=(0.1, 0.25))),
            ('nearer', white._replace(texture=texture, scale=(0.1, 0.25))),
            # what a shader makes of the others is not known
            ('pond', white._replace(color=(0.1, 0.4, 0.3, 1), texture=texture))):
        assert read(script(name, *uris), find) == (expected, ''), name
    material, missing = read(script('lost', *uris), find)
    assert (material.color, missing) == ((0.5, 0.5, 0.5, 1), 'texture lost.png')
    for name in ('commented', 'cours', 'Gazebo/NoSuchColor'):
        material, missing = read(script(name, *uris), find)
        assert (material, missing) == (None, 'material ' + name)


@pytest.mark.parametrize('uris, asked', [
    ((), ['file://media/materials/scripts']), (('',), ['file://media/materials/scripts']),
    (('', ' model://m ', 'model://n'), ['model://m', 'model://n'])])
def test_scripts_are_searched_for_where_the_material_says(uris, asked):
    found = []
    assert read(script('first', *uris), found.append) == (None, 'material first')
    assert found == asked


def found_in(folder, name):
    """Return the color of a material, None without one."""
    found = materials.find_in_scripts(name, [str(folder)])
    return None if found is None else found[0].color


def test_the_first_of_several_scripts_counts(tmp_path):
    for file, color in (('b.material', '0 0 1'), ('a.material', '1 0 0'), ('0.txt', '0 1 0')):
        (tmp_path / file).write_bytes(b'// caf\xe9\nmaterial m { diffuse %s }\nmaterial %s { '
                                      b'diffuse 0 1 1 }' % (color.encode(), file[0].encode()))
    assert found_in(tmp_path, 'm') == (1, 0, 0, 1)
    assert found_in(tmp_path, 'b') == (0, 1, 1, 1) and found_in(tmp_path, '0') is None


@pytest.mark.parametrize('more, color', [(0, (1, 0, 0, 1)), (1, None)])
def test_a_script_of_more_than_a_mebibyte_is_not_read(tmp_path, more, color):
    script_of_m = 'material m { diffuse 1 0 0 }\n//'
    (tmp_path / 'a.material').write_text(script_of_m.ljust((1 << 20) + more, 'x'))
    assert found_in(tmp_path, 'm') == color


@pytest.mark.parametrize('parents, color', [(9, (1, 0, 0, 1)), (10, (1, 1, 1, 1))])
def test_a_material_has_so_many_ancestors(tmp_path, parents, color):
    (tmp_path / 'a.material').write_text('material m0 { diffuse 1 0 0 }\n' + ''.join(
        'material m{} : m{} {{}}\n'.format(each + 1, each) for each in range(parents)))
    assert found_in(tmp_path, 'm{}'.format(parents)) == color


@pytest.mark.parametrize('inside, is_cutout', [
    ('', False), ('alpha_rejection greater 128', True), ('alpha_rejection always_pass', False),
    ('scene_blend alpha_blend', True), ('scene_blend add', False)])
def test_textures_that_are_cut_out(tmp_path, inside, is_cutout):
    (tmp_path / 'a.material').write_text('material m {{ {} }}'.format(inside))
    material, _ = materials.find_in_scripts('m', [str(tmp_path / 'a.material')])
    assert material.is_cutout is is_cutout
