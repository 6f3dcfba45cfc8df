"""What is said of worlds: what stands in them, and what is left out."""
import pytest

from img_recog.checks import world_check
from img_recog.checks.report import Row
from img_recog_helpers.refusals import refusal
from img_recog_helpers.sdf import BOX, BUILT_IN, CRATE, SHELF, sdf

CHAIR = '<include><uri>model://chair</uri></include>'
LAMP = '<light name="lamp" type="point"/><plugin name="p" filename="libwind.so"/><physics/>'
MESH = ('<model name="statue"><static>1</static><link name="l"><visual name="v"><geometry><mesh>'
        '<uri>{}</uri></mesh></geometry></visual></link></model>')
PAINTED = ('<model name="wall"><static>1</static><link name="l">'
           + BOX.format('visual', '<material><script><name>Gone</name></script></material>',
                        '1 2 3') + '</link></model>')


@pytest.fixture
def check(tmp_path):
    """A function that checks a world with some models."""
    def run(*models, **options):
        path = tmp_path / 'hall.world'
        path.write_text(sdf(*models))
        return world_check.check(str(path), **options)
    return run


def visible(model):
    return model.replace('</link>', BOX.format('visual', '', '0.8 0.8 0.2') + '</link>')


def test_models_sizes_and_the_rest(check, tmp_path):
    report = check(visible(SHELF), CRATE.format('3 0 0.1 0 0 0'), BUILT_IN, LAMP)
    assert report.title == 'world hall in {}'.format(tmp_path / 'hall.world')
    assert report.rows == [
        Row('simulated', 'model shelf', 'static, 0.8 x 0.8 x 0.2 m'),
        Row('simulated', 'model crate', '2 kg, not drawn'),
        Row('simulated', 'models', '2, 0.8 x 0.8 x 0.2 m'),
        Row('simulated', 'floor', 'at z 0'),
        Row('simulated', 'gravity', '0 0 -9.8 m/s2'),
        Row('not simulated', 'plugin libwind.so', 'world default'),
        Row('simulated', 'drawn', '1 shapes, 12 triangles, 0 mesh files, 0 textures')]
    assert report.problem == ''
    assert [line.split(': ', 1)[1] for line in report.warnings] == [
        'not simulated: plugin libwind.so of world default']
    assert report.is_partial


def test_what_is_left_out_needs_the_option(check, tmp_path):
    report = check(SHELF, CHAIR, MESH.format('lost.dae'))
    option = 'needs allow_partial_world:=true'
    assert report.rows[-2:] == [Row('left out', 'model://chair', option),
                                Row('left out', 'mesh lost.dae', option)]
    assert report.problem == (
        'something is left out of it; start it with allow_partial_world:=true')
    assert check(SHELF, CHAIR, allow_partial=True).problem == ''


def test_files_and_materials_that_cannot_be_used_are_not_drawn(check, tmp_path):
    (tmp_path / 'a.obj').write_text('o nothing\n')
    rows = check(MESH.format('a.obj'), PAINTED).rows
    mesh, material = [row.what for row in rows if row.state == 'not drawn']
    assert mesh.startswith('cannot read the mesh {}'.format(tmp_path / 'a.obj'))
    assert material == 'material Gone'


def test_a_texture_that_cannot_be_read_is_something_that_is_missing(check, tmp_path):
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n'
                                    'usemtl m\nf 1/1 2/1 3/1\n')
    (tmp_path / 'a.mtl').write_text('newmtl m\nKd 1 1 1\n')
    assert not check(MESH.format('a.obj')).is_partial
    (tmp_path / 'a.mtl').write_text('newmtl m\nKd 1 1 1\nmap_Kd lost.png\n')
    report = check(MESH.format('a.obj'))
    assert report.is_partial and report.rows[-1].state == 'not drawn'


def test_a_file_that_cannot_be_used_is_refused(check, tmp_path):
    assert refusal(world_check.check, str(tmp_path / 'none.world')).startswith(
        "world: got '{}', which cannot be read as a file".format(tmp_path / 'none.world'))
