"""The lights of worlds, models and robots, and what is around a world."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import lights, world_file
from img_recog.model import (DIRECTIONAL, EXP2, LINEAR, POINT, SPOT, SUN, Fog, Light,
                             Surroundings)
from img_recog.rotations import IDENTITY
from img_recog.simulation.pictures import visual_scene
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog_helpers.parsed import given
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burger
from img_recog_helpers.sdf import BUILT_IN, sdf

LAMP = '<light name="{}" type="point"><pose>1 0 2 0 0 0</pose></light>'


def light(inside, kind=POINT):
    return lights.light(ElementTree.fromstring('<light name="l" type="{}">{}</light>'.format(
        kind, inside)), IDENTITY)


def test_a_light_without_values_has_those_of_sdf():
    assert light('') == Light(POINT, IDENTITY)
    assert Light(POINT) == Light(POINT, IDENTITY, (1, 1, 1), (0.1, 0.1, 0.1), (0, 0, -1), 10,
                                 (1, 1, 0), (0, 0, 0))


def test_the_values_of_a_light():
    found = light('<diffuse>0.5 0.25 0 1</diffuse><specular>0.1 0.2 0.3</specular>'
                  '<direction>1 0 -2</direction><attenuation><range>7</range><constant>0.5'
                  '</constant><linear>3</linear><quadratic>4</quadratic></attenuation><spot>'
                  '<inner_angle>0.5</inner_angle><outer_angle>1</outer_angle><falloff>2</falloff>'
                  '</spot>', SPOT)
    assert found == Light(SPOT, IDENTITY, (0.5, 0.25, 0), (0.1, 0.2, 0.3), (1, 0, -2), 7,
                          (0.5, 1, 4), (0.5, 1, 2))
    assert light('<attenuation><range>inf</range></attenuation>').reach == float('inf')


@pytest.mark.parametrize('inside, kind, words', [
    ('', 'lamp', "light l of type 'lamp', expected directional, point, spot"),
    ('<direction>0 0 0</direction>', SPOT, '<direction> of light l: got 0 0 0'),
    ('<diffuse>red</diffuse>', POINT, "<diffuse> of light l: got 'red'"),
    ('<attenuation><range>far</range></attenuation>', POINT, '<range> of light l: got')])
def test_wrong_lights_are_refused(inside, kind, words):
    assert words in refusal(light, inside, kind)


@pytest.mark.parametrize('inside, expected', [
    ('', Surroundings()), ('<ambient>1 0.5 0 1</ambient>', Surroundings((1, 0.5, 0))),
    ('<background>0 0 1</background><sky/>', Surroundings(background=(0, 0, 1), has_sky=True)),
    ('<fog/>', Surroundings()), ('<fog><type>none</type></fog>', Surroundings()),
    ('<fog><type>linear</type><start>2</start><end>9</end></fog>',
     Surroundings(fog=Fog(LINEAR, start=2, end=9))),
    ('<fog><type>exp2</type><color>1 0 0</color><density>0.2</density></fog>',
     Surroundings(fog=Fog(EXP2, (1, 0, 0), density=0.2)))])
def test_the_surroundings_of_a_world(inside, expected):
    assert lights.surroundings(ElementTree.fromstring('<scene>{}</scene>'.format(inside))
                               ) == expected


def read(path, text):
    path.write_text(text)
    return world_file.read(str(path), {}, allow_partial=True)


def test_the_lights_of_a_world(tmp_path):
    path = tmp_path / 'a.world'
    assert read(path, sdf()).lights == ()
    sun, = read(path, sdf(BUILT_IN)).lights
    assert sun._replace(pose=IDENTITY) == SUN and not sun.pose.translation.any()
    moved = BUILT_IN.replace('sun</uri>', 'sun</uri><name>moon</name><pose>1 2 3 0 0 0</pose>')
    moon, lamp = read(path, sdf(moved, LAMP.format('a'), LAMP.format('a'))).lights
    assert moon._replace(pose=IDENTITY) == SUN and moon.pose.translation.tolist() == [1, 2, 3]
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
    wrong = read(path, sdf('<light name="c" type="candle"/>'))
    assert wrong.lights == () and wrong.left_out == (
        "light c of type 'candle', expected directional, point, spot",)


def test_a_light_of_a_link_moves_with_it(tmp_path):
    path = tmp_path / 'a.world'
    path.write_text(sdf('<model name="m"><pose>0 0 1 0 0 0</pose><link name="l"><pose>0 3 0 0 0 0'
                        '</pose>{}</link></model>'.format(LAMP.format('a'))))
    tag = '<gazebo reference="base_scan">{}</gazebo></robot>'.format(LAMP.format('b'))
    built = assemble(str(path), urdf=burger().replace('</robot>', tag))
    parts = Parts(built.simulator)
    found = visual_scene.read(built.scene, parts).lights
    names = {number: name for each in parts.numbers() for name, number in each.items()}
    places = {names[part]: each.pose.translation for part, each in found if part >= 0}
    assert places['l'].tolist() == [1, 0, 2]
    # lumped: the scanner is on the base
    scanner = given(burger()).links
    assert len(places) == 2 and 'base_footprint' in places and len(scanner) > 1
    assert places['base_footprint'] == pytest.approx([1 - 0.032, 0, 2.182], abs=0.01)
    assert all(each.kind != DIRECTIONAL for part, each in found)
