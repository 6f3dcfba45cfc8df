"""Shapes of a URDF: what is read of them, and numbers that are refused."""
import pytest

from img_recog.simulation import assembly
from img_recog.simulation.settings import SimulationError
from img_recog_testing.robots import assemble, burger

LINK = '<link name="base_scan">'


def robot(inside):
    return burger().replace(LINK, LINK + inside)


def refusal(inside):
    with pytest.raises(SimulationError) as error:
        assembly.read_robot(robot(inside), 0.001, lambda uri: '/a.stl', 'robot.urdf')
    assert '\n' not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('shape, words', [
    ('<box size="nan 1 1"/>', "size of box: got 'nan 1 1', expected 3 finite numbers"),
    ('<box size="1 1e300 1"/>', "size of box: got '1 1e300 1', expected numbers from -1e+06 to"),
    ('<box size="1 1"/>', "size of box: got '1 1', expected 3"),
    ('<box size="1 -1 1"/>', 'size of box: got 1 -1 1, expected no negative number'),
    ('<sphere radius="inf"/>', "radius of sphere: got 'inf', expected 1 finite number"),
    ('<cylinder radius="1"/>', 'length of cylinder: got None, expected 1 finite number'),
    ('<cylinder radius="1" length="-2"/>', 'size of cylinder: got 1 -2, expected no negative'),
    ('<mesh filename="a.stl" scale="1 1 1e7"/>', "scale of mesh: got '1 1 1e7', expected")])
def test_a_size_that_cannot_be_used_is_refused(tag, shape, words):
    assert refusal('<{0}><geometry>{1}</geometry></{0}>'.format(tag, shape)).startswith(
        'cannot use the robot in robot.urdf: link base_scan, <{}>: {}'.format(tag, words))


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('value', ['nan', '1e300', 'x', '-2e6'])
def test_a_place_that_cannot_be_used_is_refused(tag, value):
    shape = '<geometry><sphere radius="1"/></geometry>'
    assert "<origin> in <{} here>: got '0 {} 0', expected".format(tag, value) in refusal(
        '<{0} name="here"><origin xyz="0 {1} 0"/>{2}</{0}>'.format(tag, value, shape))


def test_sizes_of_zero_and_mirrored_meshes_are_allowed(tmp_path):
    (tmp_path / 'a.obj').write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
    shapes = ('<box size="0 1 1"/>', '<sphere radius="0"/>', '<cylinder radius="0" length="0"/>',
              '<mesh filename="{}" scale="-1 1 1"/>'.format(tmp_path / 'a.obj'))
    visuals = ''.join('<visual><geometry>{}</geometry></visual>'.format(each) for each in shapes)
    assert assemble(urdf=robot(visuals), find_mesh=lambda uri: uri).warnings == ()
