"""Shapes of an SDF link as those of a URDF."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from img_recog import mesh_file
from img_recog.simulation.descriptions import sdf_file, sdf_links, urdf_visuals
from img_recog.simulation.descriptions.geometry import IDENTITY, from_rpy
from img_recog.visuals import WHOLE, Submesh
from img_recog_testing.refusals import refusal


def convert(geometry, tag='collision', pose=IDENTITY, concave=True, material='',
            find=lambda uri: None):
    """Return the shape of a URDF, None without one, and what is missing."""
    link = ElementTree.Element('link')
    shape = ElementTree.fromstring('<{0} name="s"><geometry>{1}</geometry>{2}</{0}>'.format(
        tag, geometry, material))
    missing = sdf_links.add_shape(link, shape, pose, find, concave)
    return link.find(tag), missing


@pytest.mark.parametrize('geometry, expected', [
    ('<box><size>1 2 3</size></box>', ('box', {'size': '1.0 2.0 3.0'})),
    ('<cylinder><radius>0.5</radius><length>2</length></cylinder>',
     ('cylinder', {'radius': '0.5', 'length': '2.0'})),
    ('<sphere><radius>0.25</radius></sphere>', ('sphere', {'radius': '0.25'}))])
def test_primitive_shapes_are_where_they_were(geometry, expected):
    shape, missing = convert(geometry, pose=from_rpy((1, 2, 3), (0.1, 0, 0)))
    element, = shape.find('geometry')
    assert (element.tag, element.attrib) == expected and missing == ''
    assert shape.find('origin').get('xyz') == '1.0 2.0 3.0'
    assert [float(word) for word in shape.find('origin').get('rpy').split()] == pytest.approx(
        [0.1, 0, 0])


@pytest.mark.parametrize('normal, place, size', [
    ('0 0 1', (0, 0, -0.005), '4.0 2.0 0.01'), ('0 0 -2', (0, 0, 0.005), '4.0 2.0 0.01'),
    ('1 0 0', (-0.005, 0, 0), '4.0 2.0 0.01'),
    ('2 3 6', (-0.01 / 7, -0.015 / 7, -0.03 / 7), '4.0 2.0 0.01'),
    ('-2 3 -6', (0.01 / 7, -0.015 / 7, 0.03 / 7), '4.0 2.0 0.01')])
def test_a_plane_is_the_upper_side_of_a_thin_box(normal, place, size):
    shape, _ = convert('<plane><normal>{}</normal><size>4 2</size></plane>'.format(normal))
    assert shape.find('geometry/box').get('size') == size
    origin = shape.find('origin')
    assert [float(word) for word in origin.get('xyz').split()] == pytest.approx(place, abs=1e-12)
    upper = from_rpy((0, 0, 0), [float(word) for word in origin.get('rpy').split()])
    direction = np.array([float(word) for word in normal.split()])
    assert upper.rotation[:, 2] == pytest.approx(direction / np.linalg.norm(direction))


@pytest.mark.parametrize('tag, concave, expected', [
    ('collision', True, 'yes'), ('collision', False, None), ('visual', True, None)])
def test_a_mesh(tmp_path, tag, concave, expected):
    path = tmp_path / 'a.stl'
    path.write_text('')
    shape, missing = convert('<mesh><uri>model://m/a.stl</uri><scale>2 2 3</scale></mesh>', tag,
                             concave=concave, find={'model://m/a.stl': str(path)}.get)
    mesh = shape.find('geometry/mesh')
    assert mesh.attrib == {'filename': str(path), 'scale': '2.0 2.0 3.0'}
    assert shape.get('concave') == expected and missing == ''
    assert shape.find('material') is None       # that of the file counts


@pytest.mark.parametrize('inside, submesh', [
    ('', WHOLE), ('<submesh><name> a </name></submesh>', Submesh('a')),
    ('<submesh><name>a</name><center>true</center></submesh>', Submesh('a', is_centered=True)),
    ('<submesh><name>a</name><center>0</center></submesh>', Submesh('a'))])
@pytest.mark.parametrize('tag', ['visual', 'collision'])
def test_a_part_of_a_mesh(tmp_path, tag, inside, submesh):
    (tmp_path / 'a.stl').write_text('')
    shape, _ = convert('<mesh><uri>a</uri>{}</mesh>'.format(inside), tag,
                       find=lambda uri: str(tmp_path / 'a.stl'))
    assert urdf_visuals.submesh_of(shape.find('geometry/mesh')) == submesh


@pytest.mark.parametrize('geometry, words', [
    ('', '<collision s> has no geometry'),
    ('<heightmap><uri>a.png</uri></heightmap>', 'heightmap a.png'),
    ('<image><uri>a.png</uri></image>', '<image> of collision s'),
    ('<mesh><uri>model://m/none.dae</uri></mesh>', 'mesh model://m/none.dae'),
    ('<mesh><uri>model://m/folder</uri></mesh>', 'mesh model://m/folder'),
    ('<mesh><uri>model://m/a.ply</uri></mesh>',
     'mesh model://m/a.ply (.dae, .obj, .stl are read)')])
def test_what_cannot_be_had_is_named(tmp_path, geometry, words):
    path = tmp_path / 'a.ply'
    path.write_text('')
    assert refusal(convert, geometry, find={'model://m/a.ply': str(path),
                                            'model://m/folder': str(tmp_path)}.get) == words


@pytest.mark.parametrize('geometry, words', [
    ('<box><size>1 2</size></box>', "<size> of collision s: got '1 2', expected 3 finite numbers"),
    ('<box/>', '<size> of collision s: got None, expected 3 finite numbers'),
    ('<box><size>1 0 1</size></box>', "<size> of collision s: got '1 0 1', expected more than 0"),
    ('<sphere><radius>nan</radius></sphere>', "<radius> of collision s: got 'nan', expected 1"),
    ('<plane><normal>0 0 0</normal></plane>', '<normal> of collision s: got 0 0 0, expected a')])
def test_wrong_numbers_are_refused(geometry, words):
    assert words in refusal(convert, geometry)


def test_a_visual_has_its_color():
    shape, missing = convert('<box><size>1 1 1</size></box>', 'visual',
                             material='<material><script><name>Gazebo/Orange</name></script>'
                             '</material>')
    color = shape.find('material/color').get('rgba')
    assert (color, missing) == ('1.0 0.5088 0.0468 1.0', '')


def test_materials_of_different_colors_have_different_names():
    names = [convert('<box><size>1 1 1</size></box>', 'visual', material=(
        '<material><diffuse>{} 0 0</diffuse></material>').format(red))[0].find('material').get(
            'name') for red in (0.5, 0.6, 0.5)]
    assert names[0] != names[1] and names[0] == names[2]


def test_relative_paths(tmp_path):
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'a.stl').write_text('')
    found = {'model://b': 'found', 'file://elsewhere/a.stl': 'there'}
    find = sdf_file.find_relative(str(tmp_path), found.get)
    assert find('meshes/a.stl') == str(tmp_path / 'meshes' / 'a.stl')
    assert find('file://meshes') == str(tmp_path / 'meshes')
    assert find('file://' + str(tmp_path / 'meshes')) == str(tmp_path / 'meshes')
    assert (find('model://b'), find('none'), find('')) == ('found', None, None)
    assert find('file://elsewhere/a.stl') == 'there'


def test_a_plane_without_values():
    shape, _ = convert('<plane/>')
    assert shape.find('geometry/box').attrib == {'size': '1.0 1.0 0.01', 'plane': 'true'}
    assert shape.find('origin').get('xyz') == '0.0 0.0 -0.005' and shape.get('name') == 's'
    # turned about y
    shape, _ = convert('<plane><normal>1 0 1</normal></plane>')
    assert [float(word) for word in shape.find('origin').get('rpy').split()] == pytest.approx(
        [0, np.pi / 4, 0])


def test_the_transparency_of_a_visual_without_a_material(tmp_path):
    (tmp_path / 'a.STL').write_text('')
    transparent = '<transparency>0.25</transparency>'
    shape, _ = convert('<box><size>1 1 1</size></box>', 'visual', material=transparent)
    assert shape.find('material/color').get('rgba') == '0.7 0.7 0.7 0.75'
    shape, _ = convert('<mesh><filename> a </filename></mesh>', 'visual', material=transparent,
                       find={'a': str(tmp_path / 'a.STL')}.get)
    assert shape.get('opacity') == '0.75' and shape.find('material') is None
    assert shape.find('geometry/mesh').attrib == {
        'filename': str(tmp_path / 'a.STL'), 'scale': '1.0 1.0 1.0'}


def test_a_material_that_is_missing_is_named():
    _, missing = convert('<box><size>1 1 1</size></box>', 'visual', material=(
        '<material><script><name>Gazebo/Plaid</name></script></material>'))
    assert missing == 'material Gazebo/Plaid'


def test_a_polyline_is_a_prism():
    shape, _ = convert('<polyline><point>1 2</point><point>3 2</point><point>1 5</point>'
                       '<height>4</height></polyline>')
    mesh = shape.find('geometry/mesh')
    part, = mesh_file.read(mesh.get('filename'))
    corners = part.positions.reshape(-1, 3) * [float(each) for each in mesh.get('scale').split()]
    assert corners.min(axis=0) == pytest.approx([1, 2, 0])
    assert corners.max(axis=0) == pytest.approx([3, 5, 4])


def test_the_inertia_is_where_the_link_is():
    link = ElementTree.Element('link')
    source = ElementTree.fromstring(
        '<link name="a"><inertial><pose>1 2 3 0 0 0.5</pose><mass>2</mass><inertia><ixx>1</ixx>'
        '<ixy>0.1</ixy><ixz>0.2</ixz><iyy>2</iyy><iyz>0.3</iyz><izz>2.5</izz></inertia>'
        '</inertial></link>')
    assert sdf_links.add_inertial(link, source, from_rpy((10, 20, 30), (0, 0, np.pi / 2))) == ''
    origin = link.find('inertial/origin')
    assert [float(word) for word in origin.get('xyz').split()] == pytest.approx([8, 21, 33])
    assert [float(word) for word in origin.get('rpy').split()] == pytest.approx(
        [0, 0, 0.5 + np.pi / 2])
    assert link.find('inertial/inertia').attrib == {
        'ixx': '1.0', 'ixy': '0.1', 'ixz': '0.2', 'iyy': '2.0', 'iyz': '0.3', 'izz': '2.5'}
