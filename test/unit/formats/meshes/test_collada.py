"""COLLADA files of all kinds that Gazebo reads give all of their triangles."""
import numpy as np
import pytest

from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.file_material import UNSTATED
from img_recog.model import WHITE

IMAGE = '<library_images><image id="i"><init_from>a%20b.png</init_from></image></library_images>'
SURFACE = ('<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>'
           '<newparam sid="p"><sampler2D><source>s</source></sampler2D></newparam>')
DIFFUSE = '<diffuse><color>0.2 0.4 0.6 1</color></diffuse>'
TEXTURE = '<diffuse><texture texture="p" texcoord="u"/></diffuse>'
TRIANGLES = ('<triangles count="2" material="m1">{}<p>0 0 0 1 0 1 2 0 2 0 0 0 2 0 2 3 0 3</p>'
             '</triangles>')
INPUTS = ('<input semantic="VERTEX" source="#v" offset="0"/>'
          '<input semantic="NORMAL" source="#n" offset="1"/>'
          '<input semantic="TEXCOORD" source="#t" offset="2" set="0"/>')
NODE = '<node>{}<instance_geometry url="#g">{}</instance_geometry></node>'
BIND = ('<bind_material><technique_common><instance_material symbol="m1" target="#m"/>'
        '</technique_common></bind_material>')
POINTS = '0 0 0 2 0 0 2 1 0 0 1 0'
UVS = '0 0 1 0 1 1 0 1'


def source(name, values, components):
    return ('<source id="{0}"><float_array id="{0}a" count="{1}">{2}</float_array>'
            '<technique_common><accessor source="#{0}a" count="{3}" stride="{4}">{5}</accessor>'
            '</technique_common></source>').format(
                name, len(values.split()), values, len(values.split()) // len(components),
                len(components), ''.join('<param name="{}" type="float"/>'.format(each)
                                         for each in components))


def collada(shader=DIFFUSE, primitives=TRIANGLES.format(INPUTS), nodes=NODE.format('', BIND),
            extra='', uvs=source('t', UVS, 'ST'), effect=SURFACE, image=IMAGE):
    """Return the text of a rectangle of 2 m x 1 m."""
    return '''<?xml version="1.0"?>
<COLLADA version="1.4.1" xmlns="http://www.collada.org/2005/11/COLLADASchema"><asset/>{image}
<library_effects><effect id="e"><profile_COMMON>{effect}<technique sid="t"><phong>{shader}</phong>
</technique></profile_COMMON></effect></library_effects><library_materials><material id="m">
<instance_effect url="#e"/></material></library_materials><library_geometries><geometry id="g">
<mesh>{sources}<vertices id="v"><input semantic="POSITION" source="#x"/></vertices>{primitives}
</mesh></geometry></library_geometries>{extra}<library_visual_scenes><visual_scene id="s">{nodes}
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
'''.format(image=image, effect=effect, shader=shader, primitives=primitives, nodes=nodes,
           extra=extra,
           sources=source('x', POINTS, 'XYZ') + source('n', '0 0 1', 'XYZ') + uvs)


def read(folder, text):
    """Return the only part of a COLLADA file."""
    (folder / 'a.dae').write_text(text)
    part, = mesh_file.read(str(folder / 'a.dae'))
    assert np.linalg.norm(part.normals, axis=2) == pytest.approx(1)
    return part


def area(part):
    """Return the area of triangles that face upward."""
    sides = part.positions[:, 1:] - part.positions[:, :1]
    return np.maximum(np.cross(sides[:, 0], sides[:, 1])[:, 2], 0).sum() / 2


INSTANCE = '<instance_geometry url="#g">{}</instance_geometry>'.format(BIND)
OTHER = INPUTS.replace('offset="2"', 'offset="3"').replace(
    '<input semantic="TEX', '<input semantic="{}" source="#n" offset="2"/><input semantic="TEX')
WIDER = '<p>0 0 0 0 1 0 0 1 2 0 0 2 0 0 0 0 2 0 0 2 3 0 0 3</p>'
POLYGON = INPUTS + '{}<p>0 0 0 1 0 1 2 0 2 3 0 3</p>'
CONTROLLER = ('<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>'
              '1 0 0 0 0 1 0 0 0 0 1 5 0 0 0 1</bind_shape_matrix></skin></controller>'
              '</library_controllers>')
INSTANCE_CONTROLLER = '<node><instance_controller url="#c"><skeleton>#b</skeleton>{}' \
    '</instance_controller></node>'.format(BIND)


@pytest.mark.parametrize('changes', [
    {}, {'primitives': '<!-- a --><?b?>' + TRIANGLES.format(INPUTS + '<!-- c -->')},
    {'primitives': '<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1</p>'
     '</lines><linestrips/><triangles count="0"/>' + TRIANGLES.format(INPUTS)},
    {'primitives': TRIANGLES.format(OTHER.format('COLOR')).replace(
        TRIANGLES[TRIANGLES.index('<p>'):TRIANGLES.index('</tri')], WIDER)},
    {'primitives': TRIANGLES.format(OTHER.format('TEXTANGENT')).replace(
        TRIANGLES[TRIANGLES.index('<p>'):TRIANGLES.index('</tri')], WIDER)},
    {'primitives': '<polylist count="1" material="m1">{}</polylist>'.format(
        POLYGON.format('<vcount>4</vcount>'))},
    {'primitives': '<polygons count="1" material="m1">{}</polygons>'.format(POLYGON.format(''))},
    {'primitives': '<trifans count="1" material="m1">{}</trifans>'.format(POLYGON.format(''))},
    {'primitives': '<tristrips count="1" material="m1">{}<p>0 0 0 1 0 1 3 0 3 2 0 2</p>'
     '</tristrips>'.format(INPUTS)},
    {'uvs': source('t', '0 0 9 1 0 9 1 1 9 0 1 9', 'STP')},
    {'uvs': source('t', '0 0 9 9 1 0 9 9 1 1 9 9 0 1 9 9', 'STPQ')},
    {'uvs': source('t', '0 0 9 1 0 9 1 1 9 0 1 9 7', 'STP')},
    {'uvs': source('t', '9 ' + UVS, 'ST').replace('stride', 'offset="1" stride')},
    {'uvs': source('t', UVS, 'ST').replace('stride="2"', '')},
    {'uvs': source('t', UVS, 'ST') + '<source id="b"><float_array id="c" count="1">x'
     '</float_array></source>'},
    {'primitives': TRIANGLES.format(INPUTS + '<input semantic="TEXCOORD" source="#n" offset="1" '
                                    'set="1"/>')},
    {'nodes': '<node><instance_node url=" #used "/><instance_node url="#none"/></node>',
     'extra': '<library_nodes><node sid="used">{}</node></library_nodes>'.format(
         INSTANCE.replace('#g', 'g'))},
    {'nodes': INSTANCE_CONTROLLER + '<node><instance_controller url="#d"/></node>',
     'extra': CONTROLLER.replace('<controller', '<controller id="d"/><controller')},
    {'uvs': source('t', UVS, 'UV')}, {'uvs': source('t', UVS, 'ST').replace(' name=', ' sid=')},
    {'nodes': '<node><instance_node url="#used"/></node>',
     'extra': '<library_nodes><node id="used">{}</node></library_nodes>'.format(INSTANCE)},
    {'nodes': '<node><node>{}</node><instance_light url="#none"/><extra/></node>'.format(
        INSTANCE)},
    {'nodes': INSTANCE_CONTROLLER, 'extra': CONTROLLER},
    {'nodes': INSTANCE_CONTROLLER, 'extra': CONTROLLER.replace('<skin', '<morph').replace(
        '</skin', '</morph')}])
def test_all_of_a_mesh_is_read(tmp_path, changes):
    part = read(tmp_path, collada(**changes))
    assert part.positions.shape == (2, 3, 3) and area(part) == pytest.approx(2)
    assert part.uvs == pytest.approx(part.positions[:, :, :2] / (2, 1))
    assert part.material.color == (0.2, 0.4, 0.6, 1.0) and part.has_material and part.problem == ''
    assert part.name == ''


@pytest.mark.parametrize('spoil', [
    lambda text: '\n' + text, lambda text: '\ufeff' + text,
    lambda text: text.replace('xmlns="http://www.collada.org/2005/11/COLLADASchema"', ''),
    lambda text: text.replace('COLLADA ', 'COLLADA xmlns:xsi="http://b" ')])
def test_what_surrounds_the_content_does_not_matter(tmp_path, spoil):
    assert len(read(tmp_path, spoil(collada())).positions) == 2


def test_parts_have_the_names_of_their_nodes(tmp_path):
    (tmp_path / 'a.dae').write_text(collada(nodes='<node name="one">{}<node>{}</node><node '
                                            'name="two">{}</node></node>'.format(*[INSTANCE] * 3)))
    parts = mesh_file.read(str(tmp_path / 'a.dae'))
    assert [(part.name, len(part.positions)) for part in parts] == [('one', 4), ('two', 2)]


def test_a_mirrored_geometry_faces_outward(tmp_path):
    part = read(tmp_path, collada(nodes=NODE.format('', BIND) + NODE.format(
        '<translate>0 0 1</translate><scale>-1 1 1</scale>', BIND)))
    assert area(part) == pytest.approx(4) and part.normals[..., 2] == pytest.approx(1)
    assert part.uvs[:2] == pytest.approx(part.positions[:2, :, :2] / (2, 1))
    assert part.uvs[2:] == pytest.approx(part.positions[2:, :, :2] / (-2, 1))


@pytest.mark.parametrize('normals', [
    '<float_array id="na" count="0"/>', '<float_array id="na" count="3">0 0 0</float_array>'])
def test_normals_that_are_missing_are_those_of_the_triangles(tmp_path, normals):
    text = collada()
    begin = text.index('<float_array id="na"')
    end = text.index('<technique_common>', begin)
    part = read(tmp_path, text[:begin] + normals + text[end:])
    assert part.normals == pytest.approx(np.broadcast_to((0, 0, 1), (2, 3, 3)))


@pytest.mark.parametrize('changes', [
    {'nodes': NODE.format('', '')}, {'nodes': NODE.format('', BIND.replace('"#m"', '"#none"'))},
    {'primitives': TRIANGLES.format(INPUTS).replace(' material="m1"', '')}])
def test_texture_coordinates_need_no_material(tmp_path, changes):
    part = read(tmp_path, collada(**changes))
    assert part.uvs == pytest.approx(part.positions[:, :, :2] / (2, 1))
    assert (part.material, part.has_material) == (WHITE, False)


def test_a_symbol_that_is_not_bound_names_a_material(tmp_path):
    part = read(tmp_path, collada(nodes=NODE.format('', '')).replace('"m1"', '"m"'))
    assert part.material.color == (0.2, 0.4, 0.6, 1.0) and part.has_material


@pytest.mark.parametrize('changes', [
    {}, {'shader': TEXTURE.replace('"p"', '"i"')},
    {'effect': SURFACE.replace('<source>s</source>', '<source> s </source>')},
    {'effect': SURFACE.replace('<source>s</source>', '<instance_image url="#i"/>')},
    {'image': IMAGE.replace('<init_from>', '<init_from><ref>').replace('</i', '</ref></i', 1)}])
def test_the_texture_of_a_material_is_found(tmp_path, changes):
    part = read(tmp_path, collada(**{'shader': TEXTURE, **changes}))
    assert part.material.texture == str(tmp_path / 'a b.png') and part.has_material
    assert part.material.color == (1, 1, 1, 1)


@pytest.mark.parametrize('changes', [
    {'image': ''}, {'image': '<library_images><image id="i"/></library_images>'},
    {'effect': ''}])
def test_a_material_whose_image_is_incomplete_has_none(tmp_path, changes):
    part = read(tmp_path, collada(shader=TEXTURE, **changes))
    assert part.material.texture == '' and part.has_material
    assert len(part.positions) == 2


@pytest.mark.parametrize('shader, color', [
    ('', UNSTATED.color), ('<diffuse><color>0,5 0 0 1</color></diffuse>', UNSTATED.color),
    ('<diffuse><color>0.2 0.4</color></diffuse>', UNSTATED.color),
    ('<diffuse><color>-0.5 0.4 0.6</color></diffuse>', (0, 0.4, 0.6, 1)),
    ('<diffuse><color>0.5 0.4 0.6 0.5</color></diffuse>', (0.5, 0.4, 0.6, 0.5))])
def test_colors(tmp_path, shader, color):
    assert read(tmp_path, collada(shader=shader)).material.color == pytest.approx(color)


def test_the_light_of_a_material(tmp_path):
    shader = ''.join('<{0}><color>{1}</color></{0}>'.format(tag, color) for tag, color in (
        ('emission', '0.1 0 0 1'), ('ambient', '0 0.5 0 1'), ('specular', '0.5 0.6 0.7 1')))
    material = read(tmp_path, collada(
        shader=shader + DIFFUSE + '<shininess><float>20</float></shininess>')).material
    assert (material.emissive, material.ambient, material.specular, material.shininess) == (
        (0.1, 0, 0), (0, 0.5, 0), (0.5, 0.6, 0.7), 20)
    assert read(tmp_path, collada(shader=DIFFUSE)).material.ambient == (0.4, 0.4, 0.4)


@pytest.mark.parametrize('mode, color, amount, opacity', [
    (' opaque="A_ONE"', '1 1 1 0.5', '<transparency><float>0.5</float></transparency>', 0.25),
    (' opaque="A_ONE"', '0 0 0 0.5', '', 0.5), (' opaque="A_ZERO"', '0 0 0 0.2', '', 0.8),
    (' opaque="RGB_ZERO"', '1 1 1 1', '<transparency><float>0.25</float></transparency>', 0.75),
    (' opaque="RGB_ONE"', '0.5 0.5 0.5 1', '', 0.5), ('', '0 0 0 0', '', 1.0),
    (' opaque="RGB_ONE"', '1 0 0 1', '', 0.212671), (' opaque="RGB_ONE"', '0 1 0 1', '', 0.71516),
    (' opaque="RGB_ONE"', '0 0 1 1', '', 0.072169), ('', '1 1 1 0', '', 1.0),
    (' opaque="A_ONE"', '', '', 1.0),
    (' opaque="A_ONE"', '1 1 1', '<transparency><float>0.5</float></transparency>', 0.5),
    (' opaque="A_ONE"', '1 1 1 1', '<transparency><float>3</float></transparency>', 1),
    (' opaque="A_ZERO"', '1 1 1 1', '<transparency><float>3</float></transparency>', 0)])
def test_opacity(tmp_path, mode, color, amount, opacity):
    shader = '{}<transparent{}><color>{}</color></transparent>{}'.format(
        DIFFUSE, mode, color, amount)
    for given, rgb in ((DIFFUSE, (0.2, 0.4, 0.6)), (TEXTURE, (1, 1, 1))):
        material = read(tmp_path, collada(shader=shader.replace(DIFFUSE, given))).material
        assert material.color == pytest.approx((*rgb, opacity))


@pytest.mark.parametrize('kind, more', [
    ('triangles', '<p>0 0 0 1 0 1 2 0 2 0 0 0 2 0 2 3 0 3</p>'),
    ('polylist', '<vcount>4</vcount><p>0 0 0 1 0 1 2 0 2 3 0 3</p>'),
    ('polygons', '<p>0 0 0 1 0 1 2 0 2 3 0 3</p>'), ('trifans', '<p>0 0 0 1 0 1 2 0 2 3 0 3</p>'),
    ('tristrips', '<p>0 0 0 1 0 1 3 0 3 2 0 2</p>')])
def test_what_is_left_out_is_counted(tmp_path, kind, more):
    nodes = NODE.format('', BIND) + NODE.format('<translate>nan 0 0</translate>', BIND)
    primitives = '<{0} count="2" material="m1">{1}</{0}>'.format(kind, INPUTS + more)
    assert read(tmp_path, collada(nodes=nodes, primitives=primitives)).problem == (
        'cannot read all of the mesh {}: only 2 of its 4 triangles'.format(tmp_path / 'a.dae'))


@pytest.mark.parametrize('limit, count', [(3, None), (4, 4)])
def test_a_file_of_too_many_triangles_is_refused(tmp_path, monkeypatch, limit, count):
    monkeypatch.setattr(mesh_file, 'MAX_TRIANGLES', limit)
    text = collada(nodes=NODE.format('', BIND) * 2)
    if count:
        assert len(read(tmp_path, text).positions) == count
    else:
        with pytest.raises(mesh_file.MeshError, match='it has more than 3 triangles'):
            read(tmp_path, text)


@pytest.mark.parametrize('shader', ['lambert', 'phong', 'blinn', 'constant'])
def test_all_shaders_have_a_color(tmp_path, shader):
    text = collada().replace('phong', shader)
    assert read(tmp_path, text).material.color == (0.2, 0.4, 0.6, 1)


def test_a_constant_shader_has_the_color_of_its_glow(tmp_path):
    text = collada('<emission><color>0.1 0.2 0.6 1</color></emission>')
    part = read(tmp_path, text.replace('phong', 'constant'))
    assert part.material.color == (0.1, 0.2, 0.6, 1) and part.material.emissive == (0.1, 0.2, 0.6)


@pytest.mark.parametrize('old, new', [
    ('<instance_effect url="#e"/>', ''), ('"#e"', '"#none"'), ('phong', 'unknown')])
def test_a_material_without_an_effect(tmp_path, old, new):
    part = read(tmp_path, collada().replace(old, new))
    assert part.material == UNSTATED and part.has_material


@pytest.mark.parametrize('transform, expected', [
    ('<matrix>0 -1 0 5 2 0 0 6 0 0 3 7 0 0 0 1</matrix>', [(5, 6, 7), (5, 10, 7), (4, 6, 7)]),
    ('<rotate>1 1 1 120</rotate>', [(0, 0, 0), (0, 2, 0), (0, 0, 1)]),
    ('<rotate>2 3 6 90</rotate>', [(0, 0, 0), np.array((4, 48, -9)) * 2 / 49,
                                   np.array((-36, 9, 32)) / 49]),
    ('<translate>1 2 3</translate><rotate>0 0 2 90</rotate><scale>2 5 1</scale>',
     [(1, 2, 3), (1, 6, 3), (-4, 2, 3)]),
    ('<rotate>0 0 0.5 90</rotate>', [(0, 0, 0), (0, 2, 0), (-1, 0, 0)]),
    ('<rotate>0 0 0 90</rotate>', [(0, 0, 0), (2, 0, 0), (0, 1, 0)])])
def test_transforms(tmp_path, transform, expected):
    part = read(tmp_path, collada(nodes=NODE.format(transform, BIND)))
    found = [part.positions[0, 0], part.positions[0, 1], part.positions[1, 2]]
    assert np.array(found) == pytest.approx(np.array(expected, float), abs=1e-6)


def test_the_given_normals_turn_with_each_node(tmp_path):
    text = collada(nodes=NODE.format('', BIND) + NODE.format(
        '<rotate>0 0 1 90</rotate><scale>2 2 2</scale>', BIND))
    part = read(tmp_path, text.replace('0 0 1</float', '0.6 0 0.8</float'))
    assert part.normals[:2] == pytest.approx(np.broadcast_to((0.6, 0, 0.8), (2, 3, 3)))
    assert part.normals[2:] == pytest.approx(np.broadcast_to((0, 0.6, 0.8), (2, 3, 3)))


@pytest.mark.parametrize('scale, normal', [
    ('1 1 0.2', (0.6, 0, 4)), ('1 1 -0.2', (0.6, 0, -4)), ('1 1 0', (0, 0, 1)),
    ('-2 1 1', (-0.3, 0, 0.8))])
def test_normals_stay_at_right_angles_where_a_node_is_scaled(tmp_path, scale, normal):
    text = collada(nodes=NODE.format('<scale>{}</scale>'.format(scale), BIND))
    part = read(tmp_path, text.replace('0 0 1</float', '0.6 0 0.8</float'))
    assert part.normals == pytest.approx(np.broadcast_to(
        np.array(normal) / np.linalg.norm(normal), (2, 3, 3)))


def test_vertices_may_have_normals_and_texture_coordinates(tmp_path):
    text = collada(primitives='<triangles count="2" material="m1"><input semantic="VERTEX" '
                   'source="#v" offset="0"/><p>0 1 2 0 2 3</p></triangles>')
    position = '<input semantic="POSITION" source="#x"/>'
    normals = ' '.join(['0.6 0 0.8'] * 4)
    text = text.replace('count="3">0 0 1<', 'count="12">{}<'.format(normals)).replace(
        'source="#na" count="1"', 'source="#na" count="4"')
    part = read(tmp_path, text.replace(
        position, position + '<input semantic="NORMAL" source="#n"/><input semantic="TEXCOORD" '
        'source="#t"/><input semantic="COLOR" source="#n"/>'))
    assert part.uvs == pytest.approx(part.positions[:, :, :2] / (2, 1))
    assert part.normals == pytest.approx(np.broadcast_to((0.6, 0, 0.8), (2, 3, 3)))


@pytest.mark.parametrize('indices', [['0 1 2 5 4 3'], ['0 1 2', '5 4 3']])
@pytest.mark.parametrize('own, shares', [
    ('', True), ('<input semantic="NORMAL" source="#n" offset="0"/>', False)])
def test_corners_at_a_place_share_the_first_normal_of_vertices_as_in_gazebo(
        tmp_path, own, shares, indices):
    """The last two corners of the second triangle are at other indices than those of the first."""
    text = collada(primitives=''.join(
        '<triangles count="{}" material="m1"><input semantic="VERTEX" source="#v" offset="0"/>{}'
        '<p>{}</p></triangles>'.format(2 // len(indices), own, each) for each in indices))
    normals = ['0 0 1', '0.6 0 0.8', '0 0.6 0.8', '1 0 0', '0 1 0', '0.8 0 0.6']
    for old, new in (
            ('count="3">0 0 1<', 'count="18">{}<'.format(' '.join(normals))),
            ('source="#na" count="1"', 'source="#na" count="6"'),
            ('<input semantic="POSITION" source="#x"/>', '<input semantic="POSITION" source="#x"/>'
             '<input semantic="NORMAL" source="#{}"/>'.format('x' if own else 'n')),
            (POINTS, '0 0 0 2 0 0 2 1 0 0 1 0 2.0 1 0 0 0 -0'),
            ('source="#xa" count="4"', 'source="#xa" count="6"')):
        assert old in text
        text = text.replace(old, new)
    expected = [0, 1, 2, 0, 2, 3] if shares else [0, 1, 2, 5, 4, 3]
    (tmp_path / 'a.dae').write_text(text)
    found = np.concatenate([part.normals for part in mesh_file.read(str(tmp_path / 'a.dae'))])
    assert found.reshape(6, 3) == pytest.approx(np.array(
        [normals[number].split() for number in expected], float))


def test_a_mesh_without_texture_coordinates(tmp_path):
    part = read(tmp_path, collada(primitives=TRIANGLES.format(
        INPUTS.replace('TEXCOORD', 'COLOR')), nodes=NODE.format('', BIND) * 2))
    assert part.uvs.tolist() == [[[0, 0]] * 3] * 4 and part.material.color == (0.2, 0.4, 0.6, 1)


def test_a_skin_is_bound_after_the_pose_of_its_node(tmp_path):
    nodes = INSTANCE_CONTROLLER.replace('<node>', '<node><scale>2 2 2</scale>')
    part = read(tmp_path, collada(nodes=nodes, extra=CONTROLLER))
    assert part.positions[:, :, 2] == pytest.approx(5) and part.positions.max() == 5
    assert part.positions[:, :, 0].max() == 4


def test_controllers_may_refer_to_ten_controllers(tmp_path):
    chain = CONTROLLER.replace('#g', '#c2') + ''.join(
        '<library_controllers><controller id="c{}"><morph source="#{}"/></controller>'
        '</library_controllers>'.format(number, 'g' if number == 10 else 'c{}'.format(number + 1))
        for number in range(2, 11))
    part = read(tmp_path, collada(nodes=INSTANCE_CONTROLLER, extra=chain))
    assert part.positions[:, :, 2] == pytest.approx(5) and len(part.positions) == 2
    with pytest.raises(mesh_file.MeshError, match='it has 0 triangles'):
        read(tmp_path, collada(nodes=INSTANCE_CONTROLLER, extra=CONTROLLER.replace('#g', '#c')))
