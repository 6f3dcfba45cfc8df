"""What is said of worlds: what stands in them, and what is left out."""
import pytest

from img_recog.checks import world_check
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal
from img_recog_helpers.sdf import BOX, BUILT_IN, CRATE, SHELF, sdf

CHAIR = '<include><uri>model://chair</uri></include>'
LAMP = '<light name="lamp" type="point"/><plugin name="p" filename="libwind.so"/><physics/>'
MESH = ('<model name="statue"><static>1</static><link name="l"><visual name="v"><geometry><mesh>'
        '<uri>{}</uri></mesh></geometry></visual></link></model>')
PAINTED = ('<model name="wall"><static>1</static><link name="l">'
           + BOX.format('visual', '<material><script><name>Gone</name></script></material>',
                        '1 2 3') + '</link></model>')


JOINED = ('<model name="pole"><link name="l"><inertial><mass>2</mass></inertial></link>'
          '<joint name="j" type="fixed"><parent>world</parent><child>l</child></joint></model>')
HINGED = JOINED.replace('pole', 'door').replace('"fixed"', '"revolute"').replace(
    '</child>', '</child><axis><xyz>0 0 1</xyz></axis>')
VISIBLE = SHELF.replace('</link>', BOX.format('visual', '', '0.8 0.8 0.2') + '</link>')
TRIANGLE = ('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\n'
            'f 1/1 2/1 3/1\n')
MATERIAL = 'newmtl m\nKd 1 1 1\n'
# models, and files beside the world
CASES = {
    'models': ((VISIBLE, CRATE.format('3 0 0.1 0 0 0'), BUILT_IN, LAMP), {}),
    'joined': ((JOINED, HINGED), {}),
    'left out': ((SHELF, CHAIR, MESH.format('lost.dae')), {}),
    'not drawn': ((MESH.format('a.obj'), PAINTED), {'a.obj': 'o nothing\n'}),
    'texture': ((MESH.format('a.obj'),), {'a.obj': TRIANGLE, 'a.mtl': MATERIAL}),
    'lost texture': ((MESH.format('a.obj'),),
                     {'a.obj': TRIANGLE, 'a.mtl': MATERIAL + 'map_Kd lost.png\n'})}


@pytest.mark.parametrize('name', CASES)
def test_what_is_said_of_a_world(tmp_path, name):
    models, files = CASES[name]
    path = tmp_path / 'hall.world'
    path.write_text(sdf(*models))
    for file, content in files.items():
        (tmp_path / file).write_text(content)
    report = world_check.check(str(path))
    text = report.text() + (report.problem and report.problem + '\n')
    if report.is_partial:
        text += 'something is not done\n'
    expected.check_printed('check_world/{}.txt'.format(name.replace(' ', '_')),
                           text.replace(str(tmp_path) + '/', ''))
    assert world_check.check(str(path), allow_partial=True).problem == ''


def test_a_file_that_cannot_be_used_is_refused(tmp_path):
    assert refusal(world_check.check, str(tmp_path / 'none.world')).startswith(
        "world: got '{}', which cannot be read as a file".format(tmp_path / 'none.world'))
