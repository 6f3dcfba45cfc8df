"""Shapes and materials of a URDF that are refused or not found; others: test_whole_models.py."""
import pytest

from img_recog.report import lines_of
from img_recog.simulation.configured_model import from_urdf
from img_recog_helpers.parsed import given
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burger

SCAN = '<link name="base_scan">'


def test_an_unknown_material_is_a_warning():
    tag = '<gazebo reference="base_link"><material>Gazebo/Plaid</material></gazebo>'
    found = from_urdf(burger('').replace('</robot>', tag + '</robot>'), 0.001,
                      lambda uri: None, 'robot.urdf')
    assert lines_of(found.findings) == [
        'robot.urdf: not found, drawn in another color: material Gazebo/Plaid']


def robot(inside):
    return burger().replace(SCAN, SCAN + inside)


def read(inside):
    from_urdf(robot(inside), 0.001, lambda uri: '/a.stl', 'robot.urdf')


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('shape, words', [
    ('<box size="nan 1 1"/>', "size of box: got 'nan 1 1', expected 3 finite numbers"),
    ('<box size="1 1e300 1"/>',
     "size of box: got '1 1e300 1', expected 3 finite numbers of at most 1e+06"),
    ('<box size="1 1"/>', "size of box: got '1 1', expected 3"),
    ('<box size="1 -1 1"/>', 'size of box: got 1 -1 1, expected no negative number'),
    ('<sphere radius="inf"/>', "radius of sphere: got 'inf', expected a finite number"),
    ('<cylinder radius="1"/>', 'length of cylinder: got None, expected a finite number'),
    ('<cylinder radius="1" length="-2"/>', 'size of cylinder: got 1 -2, expected no negative'),
    ('<capsule length="1"/>', 'radius of capsule: got None, expected a finite number'),
    ('<capsule radius="1"/>', 'length of capsule: got None, expected a finite number'),
    ('<mesh filename="a.stl" scale="1 1 1e7"/>', "scale of mesh: got '1 1 1e7', expected")])
def test_a_size_that_cannot_be_used_is_refused(tag, shape, words):
    assert refusal(read, '<{0}><geometry>{1}</geometry></{0}>'.format(tag, shape)).startswith(
        'cannot use the robot in robot.urdf: link base_scan, <{}>: {}'.format(tag, words))


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('value', ['nan', '1e300', 'x', '-2e6'])
def test_a_place_that_cannot_be_used_is_refused(tag, value):
    shape = '<geometry><sphere radius="1"/></geometry>'
    assert "<origin> in <{} here>: got '0 {} 0', expected".format(tag, value) in refusal(
        read, '<{0} name="here"><origin xyz="0 {1} 0"/>{2}</{0}>'.format(tag, value, shape))


def test_sizes_of_zero_and_mirrored_meshes_are_allowed(tmp_path):
    (tmp_path / 'a.obj').write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
    shapes = ('<box size="0 1 1"/>', '<sphere radius="0"/>', '<cylinder radius="0" length="0"/>',
              '<mesh filename="{}" scale="-1 1 1"/>'.format(tmp_path / 'a.obj'))
    visuals = ''.join('<visual><geometry>{}</geometry></visual>'.format(each) for each in shapes)
    assert assemble(urdf=robot(visuals), find_mesh=lambda uri: uri).world.report.lines() == []


def test_a_relative_path_of_a_mesh_becomes_absolute(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    link, = given('<robot><link name="l"><visual><geometry><mesh filename="m"/></geometry>'
                  '</visual></link></robot>', lambda uri: 'b/a.STL').links
    assert link.looks[0].shape.path == str(tmp_path / 'b' / 'a.STL')
