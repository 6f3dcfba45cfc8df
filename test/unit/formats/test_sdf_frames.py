"""Where frames, states and includes put the links of an SDF: figures of Gazebo 11."""
import numpy as np
import pytest

from img_recog.formats import world_file
from img_recog.rotations import to_rpy
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.sdf import sdf

FRAMES = ('<frame name="f"><pose>1 0 0 0 0 1.5707963</pose></frame>'
          '<frame name="g" attached_to="f"><pose>1 0 0 0 0 0</pose></frame>'
          '<frame name="h" attached_to="f"><pose relative_to="g">1 0 0 0 0 0</pose></frame>'
          '<frame name="of_m" attached_to="m"><pose>0 0 1 0 0 0</pose></frame>')
MODEL = '<model name="{}"><pose{}>{}</pose><static>1</static>{}</model>'
A, B = '<link name="a"/>', '<link name="b"><pose{}>{}</pose></link>'
M = MODEL.format('m', '', '3 0 0 0 0 0.5', A)
HOST = ('<model name="host"><pose>0 0 10 0 0 0.5</pose><static>{}</static>' + A + '<include><uri>'
        'thing.sdf</uri><name>inc</name><pose>1 0 0 0 0 0.2</pose></include></model>')
JOINTED = ('<joint name="j" type="fixed"><pose>0 1 0 0 0 0</pose><parent>a</parent><child>b'
           '</child></joint><frame name="k" attached_to="j"><pose>0 0 1 0 0 0</pose></frame>'
           '<link name="c"><pose relative_to="k">0 0 2 0 0 0</pose></link>')
THING = ('<sdf version="1.7"><model name="thing"><pose>0 0 2 0 0 0</pose><static>1</static>'
         '<frame name="g"><pose>0 3 0 0 0 0</pose></frame><link name="a"><pose>0 1 0 0 0 0</pose>'
         '</link><link name="b"><pose relative_to="g">0 0 1 0 0 0</pose></link></model></sdf>')
INCLUDE = '<include><uri>thing.sdf</uri><name>{}</name>{}</include>'
STATE = ('<state world_name="default"><model name="m">{}<link name="a"><pose>2 1 3 0 0 0.5</pose>'
         '</link></model></state>')


def read(folder, *models, version='1.7'):
    (folder / 'thing.sdf').write_text(THING)
    (folder / 'hall.world').write_text(sdf(*models, version=version))
    return world_file.read(str(folder / 'hall.world'), {})


def place(file, link):
    """Return x, y, z and yaw of a link at the start."""
    model, _, name = link.partition('::')
    pose, = [tree.pose @ tree.model.frames[name].pose for tree in file.trees
             if tree.name.partition('::')[0] == model and name in tree.model.frames]
    return [*pose.translation, to_rpy(pose.rotation)[2]]


@pytest.mark.parametrize('models, link, where', [
    ([FRAMES, M, MODEL.format('n', ' relative_to="f"', '1 0 0.1 0 0 0', A)], 'n::a',
     (1, 1, 0.1, 1.5708)),
    ([FRAMES, M, MODEL.format('n', ' relative_to="g"', '0 0 0 0 0 0', A)], 'n::a',
     (1, 1, 0, 1.5708)),
    ([FRAMES, M, MODEL.format('n', ' relative_to="h"', '0 0 0 0 0 0', A)], 'n::a',
     (1, 2, 0, 1.5708)),
    ([FRAMES, MODEL.format('n', ' relative_to="of_m"', '0 0 0 0 0 0', A), M], 'n::a',
     (3, 0, 1, 0.5)),
    ([MODEL.format('n', ' relative_to="world"', '0 0 7 0 0 0', A)], 'n::a', (0, 0, 7, 0)),
    ([MODEL.format('n', ' relative_to="m"', '0 0 7 0 0 0', A), M], 'n::a', (3, 0, 7, 0.5)),
    ([MODEL.format('m', '', '3 0 0 0 0 0.5', A + JOINTED + B.format(' relative_to="a"',
                                                                    '1 0 0 0 0 0'))],
     'm::c', (3.3982, 1.3570, 3, 0.5)),
    ([FRAMES, M, INCLUDE.format('rel', '<pose relative_to="f">1 0 0 0 0 0</pose>')], 'rel::b',
     (-2, 1, 1, 1.5708)),
    ([INCLUDE.format('plain', ''), INCLUDE.format('rel', '<pose relative_to="plain">1 0 0 0 0 0'
                                                  '</pose>')], 'rel::b', (1, 3, 3, 0)),
    ([HOST.format(1)], 'host::inc::b', (-1.0551, 2.774, 11, 0.7))])
def test_poses_relative_to_frames(tmp_path, models, link, where):
    file = read(tmp_path, *models)
    assert place(file, link) == pytest.approx(where, abs=1e-4)
    assert file.findings == ()


@pytest.mark.parametrize('model, link, name', [
    (MODEL.format('m', ' relative_to="nowhere"', '3 0 0 0 0 0.5', A), 'm::a', 'the world model m'),
    (MODEL.format('m', '', '2 0 0 0 0 0.5', A + B.format(' relative_to="nowhere"', '1 0 0 0 0 0')),
     'm::b', 'm link b')])
def test_a_pose_relative_to_nothing_counts_without_it_and_is_named(tmp_path, model, link, name):
    file = read(tmp_path, model)
    expected = (3, 0, 0, 0.5) if link == 'm::a' else (2.8776, 0.4794, 0, 0.5)
    assert place(file, link) == pytest.approx(expected, abs=1e-4)
    assert [each.text() for each in file.findings] == ['the frame nowhere of ' + name]


def test_a_collision_is_relative_to_another_link(tmp_path):
    file = read(tmp_path, MODEL.format(
        'm', '', '0 0 0 0 0 0', '<link name="a"><collision name="c"><pose relative_to="b">0 0 1 0 '
        '0 0</pose><geometry><box><size>1 1 1</size></box></geometry></collision></link>'
        + B.format('', '5 0 0 0 0 0')))
    assert file.trees[0].model.links[0].solids[0].pose.translation.tolist() == [5, 0, 1]


@pytest.mark.parametrize('version, attributes, text, yaw, found', [
    ('1.8', ' degrees="true"', '0 0 0 0 0 90', 90 - 28 * np.pi, ['attribute degrees of <pose>']),
    ('1.9', ' degrees="true"', '0 0 0 0 0 90', np.pi / 2, []),
    ('1.10', ' degrees="1" rotation_format="euler_rpy"', '0 0 0 0 0 90', np.pi / 2, []),
    ('1.9', ' degrees="false"', '0 0 0 0 0 0.5', 0.5, []),
    ('1.9', ' rotation_format="quat_xyzw"', '0 0 0 0 0 1 1', np.pi / 2, [])])
def test_the_format_of_a_rotation(tmp_path, version, attributes, text, yaw, found):
    file = read(tmp_path, MODEL.format('m', attributes, text, A), version=version)
    assert place(file, 'm::a')[3] == pytest.approx(yaw, abs=1e-6)
    assert [each.what for each in file.findings] == found


@pytest.mark.parametrize('pose, where', [
    ('<pose>2 1 3 0 0 0.5</pose>', (2.8776, 1.4794, 3, 0.5)), ('', (1, 0, 0, 0))])
def test_the_state_of_models_and_links(tmp_path, pose, where):
    file = read(tmp_path, MODEL.format('m', '', '0 5 1 0 0 0.3', A + B.format('', '1 0 0 0 0 0')),
                STATE.format(pose))
    assert place(file, 'm::a') == pytest.approx((2, 1, 3, 0.5))
    assert place(file, 'm::b') == pytest.approx(where, abs=1e-4)


@pytest.mark.parametrize('kind, start, position', [
    ('revolute', '3 1 3 0 0 0.9', 0.4), ('prismatic', '3 1 3.25 0 0 0.5', 0.25)])
def test_the_state_of_a_joint_is_that_of_its_links(tmp_path, kind, start, position):
    file = read(tmp_path, '<gravity>0 0 0</gravity><model name="m"><pose>0 0 1 0 0 0</pose>' + A
                + B.format('', '1 0 0 0 0 0') + '<joint name="j" type="{}"><parent>a</parent>'
                '<child>b</child><axis><xyz>0 0 1</xyz></axis></joint></model>'.format(kind),
                STATE.format('').replace('</link>', '</link><link name="b"><pose>{}</pose></link>')
                .format(start))
    world = World(PhysicsSettings(), file, connect())
    body, = world.scenery
    assert body.pose().joints == pytest.approx([position])
    world.step(100)
    world.reset()
    assert body.pose().joints == pytest.approx([position]) and body.pose().position == (
        pytest.approx((2, 1, 3)))


@pytest.mark.parametrize('model, fixed', [
    (HOST.format(1), {'host': True, 'host::inc::a': True, 'host::inc::b': True}),
    (HOST.format(0), {'host': True, 'host::inc::a': True, 'host::inc::b': True}),
    (MODEL.format('m', '', '3 0 1 0 0 0.5', A + '<model name="n">' + A + '</model>'),
     {'m': True, 'm::n::a': False}),
    ('<model name="m">' + A + MODEL.format('n', '', '0 0 0 0 0 0', A) + '</model>',
     {'m': False, 'm::n::a': True})])
def test_what_is_included_is_static_with_its_model_what_is_nested_is_not(tmp_path, model, fixed):
    assert {tree.name: tree.fixed for tree in read(tmp_path, model).trees} == fixed
