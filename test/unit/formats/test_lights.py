"""The lights of worlds, models and robots, and what is around a world."""

import pytest

from img_recog.formats import world_file
from img_recog.model import DIRECTIONAL, POINT, SUN
from img_recog.rotations import IDENTITY
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog_helpers.parsed import given
from img_recog_helpers.robots import assemble, burger
from img_recog_helpers.sdf import BUILT_IN, sdf

LAMP = '<light name="{}" type="point"><pose>1 0 2 0 0 0</pose></light>'


def read(path, text):
    path.write_text(text)
    return world_file.read(str(path), {}, allow_partial=True)


def test_the_lights_of_a_world(tmp_path):
    path = tmp_path / 'a.world'
    assert read(path, sdf()).lights == ()
    sun, = read(path, sdf(BUILT_IN)).lights
    assert sun._replace(pose=IDENTITY) == SUN and not sun.pose.translation.any()
    lamp, = read(path, sdf(LAMP.format('a'), LAMP.format('a'))).lights
    assert (lamp.kind, lamp.pose.translation.tolist()) == (POINT, [1, 0, 2])
    (tmp_path / 'lamp.sdf').write_text('<sdf version="1.6">{}</sdf>'.format(LAMP.format('b')))
    included = '<include><uri>lamp.sdf</uri><pose>0 0 5 0 0 0</pose></include>'
    lamp, = read(path, sdf(included)).lights
    assert lamp.pose.translation.tolist() == [0, 0, 5]
    # those of Gazebo's empty world
    assert world_file.read('empty', {}).lights == (SUN,)
    assert read(path, '<robot name="r"><link name="l"/></robot>').lights == (SUN,)
    assert read(path, '<sdf version="1.6"><model name="m"><link name="l"/></model></sdf>'
                ).lights == (SUN,)


def test_a_light_of_a_link_moves_with_it(tmp_path):
    path = tmp_path / 'a.world'
    path.write_text(sdf('<model name="m"><pose>0 0 1 0 0 0</pose><link name="l"><pose>0 3 0 0 0 0'
                        '</pose>{}</link></model>'.format(LAMP.format('a'))))
    tag = '<gazebo reference="base_scan">{}</gazebo></robot>'.format(LAMP.format('b'))
    built = assemble(str(path), urdf=burger().replace('</robot>', tag))
    parts = Parts(built)
    found = parts.scene().lights
    names = {number: name for each in parts.numbers() for name, number in each.items()}
    places = {names[part]: each.pose.translation for part, each in found if part >= 0}
    assert places['l'].tolist() == [1, 0, 2]
    # lumped: the scanner is on the base
    scanner = given(burger()).links
    assert len(places) == 2 and 'base_footprint' in places and len(scanner) > 1
    assert places['base_footprint'] == pytest.approx([1 - 0.032, 0, 2.182], abs=0.01)
    assert all(each.kind != DIRECTIONAL for part, each in found)
