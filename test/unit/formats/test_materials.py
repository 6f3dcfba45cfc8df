"""The materials of SDF visuals."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import material_scripts, materials
from img_recog.model import GREY, Material
from img_recog_testing.refusals import refusal

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
  emissive 0 0 0 } } }
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
    return materials.of_sdf(visual, find)


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


@pytest.mark.parametrize('inside, color', [
    ('<material><diffuse>0.1 0.2 0.3 0.4</diffuse></material>', (0.1, 0.2, 0.3, 0.4)),
    ('<material><ambient>0.1 0.2 0.3</ambient></material>', (0.1, 0.2, 0.3, 1.0)),
    ('<material><ambient>1 1 1 1</ambient><diffuse>0 0 1 1</diffuse></material>', (0, 0, 1, 1)),
    ('<material><script>Gazebo/Red</script></material>', (1, 0, 0, 1)),
    (script('Gazebo/Blue'), (0, 0, 1, 1)), (script('Gazebo/GreyTransparent'), (.5, .5, .5, .5))])
def test_colors(inside, color):
    assert read(inside) == (Material(color), '')


def test_a_material_with_a_texture_of_gazebo_has_its_mean_color():
    material, _ = read(script('Gazebo/Bricks', 'file://media/materials/scripts/gazebo.material'))
    assert material == Material((0.562, 0.378, 0.37, 1))


@pytest.mark.parametrize('name, colors, color', [
    ('Gazebo/Grey', '<diffuse>0 0.5 1 1</diffuse>', (0, 0.5, 1, 1)),
    # the goal of turtlebot3_stage_1: grey in the sun, red in the shade
    ('Gazebo/Grey', '<ambient>1 0 0 1</ambient>', (0.82, 0.42, 0.42, 1)),
    ('Gazebo/GreyTransparent', '<ambient>1 0 0.5 0.1</ambient>', (0.7, 0.3, 0.5, 0.5))])
def test_colors_count_in_addition_to_a_script(name, colors, color):
    material, missing = read(script(name).replace('</material>', colors + '</material>'))
    assert material.color == pytest.approx(color) and missing == ''


@pytest.mark.parametrize('inside', [
    '', '<material/>', '<material><lighting>1</lighting><script/></material>',
    '<material><script><name>__default__</name><uri>__default__</uri></script></material>'])
def test_a_material_needs_a_script_or_a_color(inside):
    assert read(inside) == (None, '')


@pytest.mark.parametrize('transparency, opacity', [
    ('0', 0.5), ('0.5', 0.25), ('1', 0), ('2', 0), ('-1', 0.5)])
def test_transparency_is_less_opacity(transparency, opacity):
    material, _ = read('<material><diffuse>1 1 1 0.5</diffuse></material>',
                       transparency='<transparency>{}</transparency>'.format(transparency))
    assert material.color == (1, 1, 1, opacity)


@pytest.mark.parametrize('uris', [
    ('model://m/scripts', 'model://m/textures'), ('model://m/scripts/a.material',),
    ('model://m/none', 'model://m/scripts')])
def test_a_script_and_its_texture(folder, uris):
    def find(uri):
        path = folder / uri[len('model://m/'):]
        return str(path) if path.exists() else None
    assert read(script('first', *uris), find) == (Material((0.1, 0.2, 0.3, 0.5)), '')
    assert read(script('shiny', *uris), find) == (Material((0.5, 0.25, 0.5, 1)), '')
    assert read(script('broken', *uris), find) == (Material(GREY), '')
    assert read(script('glowing', *uris), find) == (Material((1, 0.5, 0.25, 0.4)), '')
    assert read(script('short', *uris), find) == (Material((0.1, 0.2, 0.3, 1)), '')
    texture = str(folder / 'textures' / 'course.png')
    assert read(script('course', *uris), find) == (Material((0.1, 0.2, 0.3, 0.5), texture), '')
    assert read(script('bare', *uris), find) == (Material((1, 1, 1, 1), texture, (0.5, 1)), '')
    assert read(script('small', *uris), find) == (Material((1, 1, 1, 1), texture), '')
    for name in ('far', 'nearer'):
        assert read(script(name, *uris), find) == (
            Material((1, 1, 1, 1), texture, (0.1, 0.25)), '')
    assert read(script('lost', *uris), find) == (Material((0.5, 0.5, 0.5, 1)), 'texture lost.png')
    for name in ('commented', 'cours', 'Gazebo/NoSuchColor'):
        material, missing = read(script(name, *uris), find)
        assert (material, missing) == (None, 'material ' + name)


@pytest.mark.parametrize('inside, words', [
    ('<material><diffuse>red</diffuse></material>', "<diffuse> of visual v: got 'red'"),
    ('<material><ambient>1 1</ambient></material>', "<ambient> of visual v: got '1 1'"),
    ('<material><diffuse>1 1 1</diffuse></material><transparency>x</transparency>',
     "<transparency> of visual v: got 'x'")])
def test_wrong_numbers_are_refused(inside, words):
    assert words in refusal(read, inside)


@pytest.mark.parametrize('inside, words', [
    ('<material><diffuse>red</diffuse></material>', "<diffuse> of visual : got 'red'"),
    ('<material><diffuse>1 1 1</diffuse></material><transparency>x</transparency>',
     "<transparency> of visual : got 'x'")])
def test_a_visual_needs_no_name(inside, words):
    visual = ElementTree.fromstring('<visual>{}</visual>'.format(inside))
    assert words in refusal(materials.of_sdf, visual, lambda uri: None)


@pytest.mark.parametrize('uris, asked', [
    ((), ['file://media/materials/scripts']), (('',), ['file://media/materials/scripts']),
    (('', ' model://m ', 'model://n'), ['model://m', 'model://n'])])
def test_scripts_are_searched_for_where_the_material_says(uris, asked):
    found = []
    assert read(script('first', *uris), found.append) == (None, 'material first')
    assert found == asked


def found_in(folder, name):
    """Return the color of a material, None without one."""
    found = material_scripts.find(name, [str(folder)])
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


@pytest.mark.parametrize('parents, color', [(9, (1, 0, 0, 1)), (10, GREY)])
def test_a_material_has_so_many_ancestors(tmp_path, parents, color):
    (tmp_path / 'a.material').write_text('material m0 { diffuse 1 0 0 }\n' + ''.join(
        'material m{} : m{} {{}}\n'.format(each + 1, each) for each in range(parents)))
    assert found_in(tmp_path, 'm{}'.format(parents)) == color


@pytest.mark.parametrize('inside, is_cutout', [
    ('', False), ('alpha_rejection greater 128', True), ('alpha_rejection always_pass', False),
    ('scene_blend alpha_blend', True), ('scene_blend add', False)])
def test_textures_that_are_cut_out(tmp_path, inside, is_cutout):
    (tmp_path / 'a.material').write_text('material m {{ {} }}'.format(inside))
    material, _ = material_scripts.find('m', [str(tmp_path / 'a.material')])
    assert material.is_cutout is is_cutout
