"""Each color on a separate link, and nothing lost."""
import pytest

from img_recog.formats import world_file
from img_recog.model import BOX, FIXED, Inertia, Joint, Link, Look, Material, Model, Shape, Solid
from img_recog.rotations import IDENTITY
from img_recog.simulation.pictures.link_colors import split_links_by_color
from img_recog_helpers.parsed import lumped
from img_recog_helpers.robots import WORLDS, burger


@pytest.fixture(params=['burger', 'turtlebot3_world'])
def model(request):
    if request.param == 'burger':
        return lumped(burger())
    return world_file.read('turtlebot3_world', WORLDS).trees[0].model


def test_every_link_has_one_color_and_every_shape_is_kept(model):
    painted = split_links_by_color(model)
    assert all(len({look.material for look in link.looks}) <= 1 for link in painted.links)
    before, after = (sum(len(link.looks) for link in each.links) for each in (model, painted))
    assert before == after > 50


def test_joints_of_the_robot_keep_their_names_and_masses(model):
    painted = split_links_by_color(model)
    assert painted.joints[:len(model.joints)] == model.joints
    for before, after in zip(model.links, painted.links):
        assert (before.name, before.inertia) == (after.name, after.inertia)


def test_added_links_have_no_mass_and_no_inertia_and_are_fixed():
    box, red = Shape(BOX, (1.0, 1.0, 1.0)), Material((1.0, 0.0, 0.0, 1.0))
    inertia = Inertia(1.0, IDENTITY, IDENTITY.rotation)
    looks = Look(box, material=red), Look(box), Look(box, material=red)
    painted = split_links_by_color(Model('r', (Link('a', inertia, (Solid(box),), looks),)))
    assert painted == Model(
        'r', (Link('a', inertia), Link('a_color_0', looks=(looks[0], looks[2])),
              Link('a_color_1', looks=(looks[1],))),
        (Joint('a_color_0_joint', FIXED, 'a', 'a_color_0'),
         Joint('a_color_1_joint', FIXED, 'a', 'a_color_1')))
