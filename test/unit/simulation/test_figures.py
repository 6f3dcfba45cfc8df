"""Joints and masses of a model that is fixed to the world, as Gazebo 11 prints them."""
import pytest

from img_recog.formats import world_file
from img_recog.simulation.figures import Figures
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator
from img_recog_helpers.sdf import BUILT_IN, sdf

JOINT = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child>{}</joint>'
MODEL = ('<model name="m"><pose>0 0 2 0 0 0.3</pose><link name="a"><inertial>'
         '<pose>0.1 0 0 0.4 0 0</pose><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy>'
         '<izz>0.15</izz></inertia></inertial></link>'
         '<link name="b"><pose>0.5 0 0 0 0 0</pose></link>'
         '<link name="c"><pose>1 0 0 0 0 0</pose></link>'
         + JOINT.format('w', 'fixed', 'world', 'a', '')
         + JOINT.format('j', 'revolute', 'a', 'b', '<axis><xyz>0 1 0</xyz></axis>')
         + JOINT.format('u', 'universal', 'b', 'c', '<axis><xyz>1 0 0</xyz></axis>'
                        '<axis2><xyz>0 1 0</xyz></axis2>') + '</model>')


def test_they_are_those_of_gazebo(tmp_path):
    path = tmp_path / 'hall.world'
    path.write_text(sdf(BUILT_IN, MODEL))
    world = World(PhysicsSettings(), world_file.read(str(path), {}), connect())
    world.step(round(0.3 / world.step_s))
    figures = Figures(Simulator(world))
    assert figures.joints() == {
        'm::w': [], 'm::j': pytest.approx([0.1768, 1.1723], abs=1e-3),
        'm::u': pytest.approx([0, 0, -0.1768, -1.1723], abs=1e-3)}
    assert figures.masses() == {
        'ground_plane::link': [0, 0, 0, 0], 'm::a': pytest.approx([2, 0.1, 0.2, 0.15]),
        'm::b': [1, 1, 1, 1], 'm::c': [1, 1, 1, 1]}
    assert figures.links()['ground_plane::link'][:7] == pytest.approx([0, 0, 0, 0, 0, 0, 1])
