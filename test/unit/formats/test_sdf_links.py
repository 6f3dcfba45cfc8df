"""Shapes of an SDF link."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from img_recog import rotations
from img_recog.formats import sdf_files, sdf_links
from img_recog.formats.meshes import mesh_file
from img_recog.model import BOX, CYLINDER, MESH, PLANE, SPHERE, WHITE, WHOLE, Shape, Submesh
from img_recog.rotations import IDENTITY, transform
from img_recog_helpers.refusals import refusal


def read(geometry, tag='collision', pose=IDENTITY, material='', find=lambda uri: None):
    """Return a solid, or a look and what is missing."""
    shape = ElementTree.fromstring('<{0} name="s"><geometry>{1}</geometry>{2}</{0}>'.format(
        tag, geometry, material))
    return (sdf_links.solid if tag == 'collision' else sdf_links.look)(shape, pose, find)


@pytest.mark.parametrize('geometry, expected', [
    ('<box><size>1 2 3</size></box>', Shape(BOX, (1, 2, 3))),
    ('<cylinder><radius>0.5</radius><length>2</length></cylinder>', Shape(CYLINDER, (0.5, 2))),
    ('<sphere><radius>0.25</radius></sphere>', Shape(SPHERE, (0.25,)))])
def test_primitive_shapes_are_where_they_were(geometry, expected):
    solid = read(geometry, pose=transform((1, 2, 3), (0.1, 0, 0)))
    assert solid.shape == expected
    assert solid.pose.translation.tolist() == [1, 2, 3]
    assert rotations.to_rpy(solid.pose.rotation) == pytest.approx([0.1, 0, 0])


@pytest.mark.parametrize('normal', ['0 0 1', '0 0 -2', '1 0 0', '2 3 6', '-2 3 -6'])
def test_a_plane_is_turned_to_its_normal(normal):
    solid = read('<plane><normal>{}</normal><size>4 2</size></plane>'.format(normal))
    assert solid.shape == Shape(PLANE, (4, 2)) and solid.pose.translation.tolist() == [0, 0, 0]
    direction = np.array([float(word) for word in normal.split()])
    assert solid.pose.rotation[:, 2] == pytest.approx(direction / np.linalg.norm(direction))


def test_a_mesh(tmp_path):
    path = tmp_path / 'a.stl'
    path.write_text('')
    mesh = '<mesh><uri>model://m/a.stl</uri><scale>2 2 3</scale></mesh>'
    find = {'model://m/a.stl': str(path)}.get
    look, missing = read(mesh, 'visual', find=find)
    assert look.shape == read(mesh, find=find).shape == Shape(MESH, (2, 2, 3), str(path))
    assert (look.material, missing) == (None, '')       # that of the file counts


@pytest.mark.parametrize('inside, submesh', [
    ('', WHOLE), ('<submesh><name> a </name></submesh>', Submesh('a')),
    ('<submesh><name>a</name><center>true</center></submesh>', Submesh('a', is_centered=True)),
    ('<submesh><name>a</name><center>0</center></submesh>', Submesh('a'))])
def test_a_part_of_a_mesh(tmp_path, inside, submesh):
    (tmp_path / 'a.stl').write_text('')
    solid = read('<mesh><uri>a</uri>{}</mesh>'.format(inside),
                 find=lambda uri: str(tmp_path / 'a.stl'))
    assert solid.shape.submesh == submesh


@pytest.mark.parametrize('geometry, words', [
    ('', '<collision s> has no geometry'),
    ('<heightmap><uri>a.png</uri></heightmap>', 'heightmap a.png'),
    ('<image><uri>a.png</uri></image>', '<image> of collision s'),
    ('<mesh><uri>model://m/none.dae</uri></mesh>', 'mesh model://m/none.dae'),
    ('<mesh><uri>model://m/folder</uri></mesh>', 'mesh model://m/folder (a folder, not a file)'),
    ('<mesh><uri>model://m/a.ply</uri></mesh>',
     'mesh model://m/a.ply (.dae, .obj, .stl are read)')])
def test_what_cannot_be_had_is_named(tmp_path, geometry, words):
    path = tmp_path / 'a.ply'
    path.write_text('')
    assert refusal(read, geometry, find={'model://m/a.ply': str(path),
                                         'model://m/folder': str(tmp_path)}.get) == words


@pytest.mark.parametrize('geometry, words', [
    ('<box><size>1 2</size></box>', "<size> of collision s: got '1 2', expected 3 finite numbers"),
    ('<box/>', '<size> of collision s: got None, expected 3 finite numbers'),
    ('<box><size>1 0 1</size></box>', "<size> of collision s: got '1 0 1', expected more than 0"),
    ('<sphere><radius>nan</radius></sphere>', "<radius> of collision s: got 'nan', expected 1"),
    ('<plane><normal>0 0 0</normal></plane>', '<normal> of collision s: got 0 0 0, expected a')])
def test_wrong_numbers_are_refused(geometry, words):
    assert words in refusal(read, geometry)


@pytest.mark.parametrize('name, color, problem', [
    ('Gazebo/Orange', (1, 0.5088, 0.0468, 1), ''),
    ('Gazebo/Plaid', (1, 1, 1, 1), 'material Gazebo/Plaid')])
def test_a_visual_has_its_color(name, color, problem):
    look, missing = read('<box><size>1 1 1</size></box>', 'visual', material='<material><script>'
                         '<name>{}</name></script></material>'.format(name))
    assert (look.material.color, missing) == (color, problem)


def test_relative_paths(tmp_path):
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'a.stl').write_text('')
    found = {'model://b': 'found', 'file://elsewhere/a.stl': 'there'}
    find = sdf_files.find_relative(str(tmp_path), found.get)
    assert find('meshes/a.stl') == str(tmp_path / 'meshes' / 'a.stl')
    assert find('file://meshes') == str(tmp_path / 'meshes')
    assert find('file://' + str(tmp_path / 'meshes')) == str(tmp_path / 'meshes')
    assert (find('model://b'), find('none'), find('')) == ('found', None, None)
    assert find('file://elsewhere/a.stl') == 'there'


def test_a_plane_without_values():
    solid = read('<plane/>')
    assert solid.shape == Shape(PLANE, (1, 1))
    assert solid.pose.matrix().tolist() == np.eye(4).tolist()
    # turned about y
    solid = read('<plane><normal>1 0 1</normal></plane>')
    assert rotations.to_rpy(solid.pose.rotation) == pytest.approx([0, np.pi / 4, 0])


def test_the_transparency_of_a_visual_without_a_material(tmp_path):
    (tmp_path / 'a.STL').write_text('')
    transparent = '<transparency>0.25</transparency>'
    look, _ = read('<box><size>1 1 1</size></box>', 'visual', material=transparent)
    assert (look.material, look.opacity) == (WHITE._replace(color=(1, 1, 1, 0.9375)), 1.0)
    look, _ = read('<mesh><filename> a </filename></mesh>', 'visual', material=transparent,
                   find={'a': str(tmp_path / 'a.STL')}.get)
    assert (look.material, look.opacity) == (None, 0.75)
    assert look.shape == Shape(MESH, (1, 1, 1), str(tmp_path / 'a.STL'))


def test_a_polyline_is_a_prism():
    solid = read('<polyline><point>1 2</point><point>3 2</point><point>1 5</point>'
                 '<height>4</height></polyline>')
    part, = mesh_file.read(solid.shape.path)
    corners = part.positions.reshape(-1, 3) * solid.shape.size
    assert corners.min(axis=0) == pytest.approx([1, 2, 0])
    assert corners.max(axis=0) == pytest.approx([3, 5, 4])


def test_the_inertia_is_where_the_link_is():
    source = ElementTree.fromstring(
        '<link name="a"><inertial><pose>1 2 3 0 0 0.5</pose><mass>2</mass><inertia><ixx>1</ixx>'
        '<ixy>0.1</ixy><ixz>0.2</ixz><iyy>2</iyy><iyz>0.3</iyz><izz>2.5</izz></inertia>'
        '</inertial></link>')
    inertia, warning = sdf_links.inertia(source, transform((10, 20, 30), (0, 0, np.pi / 2)))
    assert (inertia.mass, warning) == (2, '')
    assert inertia.pose.translation == pytest.approx([8, 21, 33])
    assert rotations.to_rpy(inertia.pose.rotation) == pytest.approx([0, 0, 0.5 + np.pi / 2])
    assert inertia.matrix.tolist() == [[1, 0.1, 0.2], [0.1, 2, 0.3], [0.2, 0.3, 2.5]]
