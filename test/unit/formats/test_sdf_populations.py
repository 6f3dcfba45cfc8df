"""Populations and roads of a world: how many models there are, and where."""
import numpy as np
import pytest

from img_recog.formats import generated_meshes, world_file
from img_recog.formats.meshes import mesh_file
from img_recog.model import NO_INERTIA
from img_recog_helpers.refusals import refusal
from img_recog_helpers.sdf import sdf

POPULATION = ('<population name="cans"><pose>10 0 1 0 0 0</pose><model name="can">'
              '<pose>0 0 0.1 0 0 0</pose><link name="l"/></model>{}</population>')
BOX = '<box><size>4 2 0.5</size></box>'
COUNT = '<model_count>{}</model_count>'
TYPE = '<distribution><type>{}</type>{}</distribution>'


@pytest.fixture
def read(tmp_path):
    """A function that reads the trees of a world."""
    def trees(*inside):
        (tmp_path / 'hall.world').write_text(sdf(*inside))
        return world_file.read(str(tmp_path / 'hall.world'), {}).trees
    return trees


def places(trees):
    return np.array([tree.pose.translation for tree in trees]) - (10, 0, 1.1)


def test_what_a_model_includes_is_a_part_of_its_copies(read, tmp_path):
    (tmp_path / 'part').mkdir()
    (tmp_path / 'part' / 'a.obj').write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
    (tmp_path / 'part' / 'a.sdf').write_text(
        '<sdf version="1.6"><model name="part"><link name="l"><visual name="v"><geometry><mesh>'
        '<filename>a.obj</filename></mesh></geometry></visual></link></model></sdf>')
    can, part = read(POPULATION.format('').replace(
        '</model>', '<include><uri>part/a.sdf</uri></include></model>'))
    look, = part.model.links[0].looks
    assert can.first and not part.first
    assert look.shape.path == str(tmp_path / 'part' / 'a.obj')


@pytest.mark.parametrize('kind', ['random', 'uniform'])
def test_random_places_are_within_the_box_and_the_same_each_time(read, kind):
    world = POPULATION.format(COUNT.format(40) + BOX + TYPE.format(kind, ''))
    found = places(read(world))
    assert found.shape == (40, 3) and len(np.unique(found, axis=0)) == 40
    assert (np.abs(found) <= (2, 1, 0.25)).all() and np.array_equal(found, places(read(world)))
    assert (np.abs(found).max(axis=0) > (1.4, 0.7, 0.15)).all()


def test_uniform_places_keep_their_distance(read):
    def nearest(kind):
        found = places(read(POPULATION.format(COUNT.format(30) + BOX + TYPE.format(kind, ''))))
        distances = np.linalg.norm(found[:, None] - found, axis=2) + 100 * np.eye(30)
        return distances.min()
    assert nearest('uniform') > 2 * nearest('random')


def test_places_in_a_cylinder(read):
    found = places(read(POPULATION.format(
        COUNT.format(400) + TYPE.format('random', '')
        + '<cylinder><radius>2</radius><length>1</length></cylinder>')))
    distances = np.linalg.norm(found[:, :2], axis=1)
    assert 1.9 < distances.max() <= 2
    assert -0.5 <= found[:, 2].min() < -0.45 and 0.45 < found[:, 2].max() <= 0.5
    # as many in the inner half of the area as in the outer one, and in all directions
    assert 170 <= (distances < np.sqrt(2)).sum() <= 230
    assert 170 <= (found[:, 0] > 0).sum() <= 230 and 170 <= (found[:, 1] > 0).sum() <= 230


def test_a_road_is_drawn_just_above_the_floor_and_carries_nothing(read):
    tree, = read('<road name="main"><width>2</width><point>0 0 0</point><point>10 0 0</point>'
                 '</road>')
    assert tree.name == tree.model.name == 'main' and tree.fixed
    assert [(link.solids, link.inertia) for link in tree.model.links] == [((), NO_INERTIA)]
    look, = tree.model.links[0].looks
    part, = mesh_file.read(look.shape.path)
    corners = part.positions.reshape(-1, 3) + look.pose.translation
    assert corners.min(axis=0) == pytest.approx([0, -1, 0.005])
    assert corners.max(axis=0) == pytest.approx([10, 1, 0.005])
    sides = part.positions[:, 1:] - part.positions[:, :1]
    heights = np.cross(sides[:, 0], sides[:, 1])[:, 2]
    assert heights.min() > 0 and heights.sum() / 2 == pytest.approx(20)     # seen from above
    assert look.material.color == pytest.approx((0.33, 0.329, 0.323, 1), abs=1e-3)


def test_a_cylinder_has_a_radius_and_length_of_1_m(read):
    found = places(read(POPULATION.format(COUNT.format(100) + '<cylinder/>')))
    assert 0.9 < np.linalg.norm(found[:, :2], axis=1).max() <= 1
    assert 0.45 < np.abs(found[:, 2]).max() <= 0.5


def test_many_uniform_places_are_random(read):
    several = [places(read(POPULATION.format(COUNT.format(301) + BOX + TYPE.format(kind, ''))))
               for kind in ('uniform', 'random')]
    assert np.array_equal(*several)


ASIDE = 0.5 * np.sqrt(0.5)


@pytest.mark.parametrize('inside, corners, along', [
    ('<width>3</width><point>0 0 1</point><point>0.5 0 1</point><point>0.5 0 1</point>'
     '<point>0.5 4 2</point><material><script><name>Gazebo/Blue</name></script></material>',
     [(0, 1.5, 1), (0, -1.5, 1), (0.5, 1.5, 1), (0.5, -1.5, 1), (-1, 0, 1), (2, 0, 1), (-1, 4, 2),
      (2, 4, 2)], [0, 0.5 / 3, 0.5 / 3, 1.5]),
    # across a corner in the mean direction
    ('<point>1 2 0</point><point>1.5 2 0</point><point>1.5 6 0</point>',
     [(1, 2.5, 0), (1, 1.5, 0), (1.5 - ASIDE, 2 + ASIDE, 0), (1.5 + ASIDE, 2 - ASIDE, 0),
      (1, 6, 0), (2, 6, 0)], [0, 0.5, 4.5])])
def test_the_corners_of_a_road(read, inside, corners, along):
    tree, = read('<road>{}</road>'.format(inside))
    assert tree.name == tree.model.name == 'road'
    look, = tree.model.links[0].looks
    part, = mesh_file.read(look.shape.path)
    uvs = np.array([(u, v) for v in along for u in (0, 1)])
    faces = generated_meshes.grid_faces(len(along), 2)
    assert part.positions == pytest.approx(np.array(corners)[faces], abs=1e-6)
    assert part.uvs == pytest.approx(uvs[faces], abs=1e-6) and look.shape.size == (1, 1, 1)
    assert (look.material.color == (0, 0, 1, 1)) is ('Blue' in inside)


def test_the_missing_look_of_a_road_and_its_name_are_told(tmp_path, read):
    (tmp_path / 'w.world').write_text(sdf(
        '<road><point>0 0 0</point><point>1 0 0</point><material><script><name>none</name>'
        '</script></material></road>'))
    assert 'material none' in str(world_file.read(str(tmp_path / 'w.world'), {}).findings)
    assert 'road has 0 points, expected 2 or more' in refusal(read, '<road/>')


def test_a_road_without_a_width_is_drawn_all_the_same(read):
    tree, = read('<road><width>0</width><point>0 0 0</point><point>3 0 0</point></road>')
    visual, = tree.model.links[0].looks
    part, = mesh_file.read(visual.shape.path)
    assert part.uvs[:, :, 1].max() == 3 and part.positions[:, :, 1].tolist() == [[0] * 3] * 2
