"""The text of a model that is added: SDF and URDF, and what is refused."""
import pytest

from img_recog.formats import model_file
from img_recog.report import Report
from img_recog_helpers.refusals import refusal

LINK = '<link name="{}"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
MASS = ('<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial>')
SDF = '<sdf version="1.6">{}</sdf>'
MODEL = '<model name="old"><pose>1 2 3 0 0 0</pose><static>1</static><link name="l"/></model>'


def nowhere(_):
    return None


def test_sdf_model_gets_the_name_and_keeps_its_pose():
    tree, = model_file.read(SDF.format(MODEL), 'goal', nowhere, Report())
    assert (tree.name, tree.fixed, tree.pose.translation.tolist()) == ('goal', True, [1, 2, 3])


def test_included_model_gets_the_name(tmp_path):
    (tmp_path / 'model.sdf').write_text(SDF.format(MODEL))
    text = SDF.format('<include><uri>model://old</uri><name>other</name></include>')
    tree, = model_file.read(text, 'goal',
                            lambda uri: str(tmp_path) if 'old' in uri else None, Report())
    assert (tree.name, tree.fixed) == ('goal', True)


def test_urdf_can_move_unless_its_root_is_the_world():
    post = LINK.format('post').replace('</link>', MASS + '</link>')
    tree, = model_file.read('<robot name="r">{}</robot>'.format(post), 'post', nowhere, Report())
    assert (tree.name, tree.fixed) == ('post', False)
    assert tree.model.links[0].inertia.mass == 2.0
    text = ('<robot name="r"><link name="world"/>{}<joint name="j" type="fixed">'
            '<parent link="world"/><child link="post"/></joint></robot>'.format(post))
    tree, = model_file.read(text, 'post', nowhere, Report())
    assert (tree.name, tree.fixed) == ('post', True)


@pytest.mark.parametrize('text, words', [
    ('', 'model m: '), ('<sdf', 'model m: '),
    ('<html/>', 'model m: got the root element <html>, expected <sdf> or <robot> (URDF)'),
    (SDF.format(''), 'model m: got 0 models, expected one <model> in <sdf>'),
    (SDF.format(MODEL * 2), 'model m: got 2 models, expected one <model> in <sdf>'),
    (SDF.format('<include><uri>model://gone</uri></include>'),
     'model m: not found, or not supported: model://gone; set GAZEBO_MODEL_PATH to'),
    ('<robot name="r">{}</robot>'.format(LINK.format('l').replace('</link>', MASS + '</link>')
                                         .replace('</visual>', '<material name="red"><color '
                                                  'rgba="1 0 x"/></material></visual>')),
     "model m: rgba of material red: got '1 0 x', expected 4 finite numbers"),
    (SDF.format('<include><uri>https://a/b</uri></include>'),
     'model m: not found, or not supported: https://a/b (a URL, which is not downloaded); '
     'download the models and include them by model://NAME, or remove that from the model'),
    (SDF.format('<model name="n"><link name="a"/><link name="b"/><joint name="j" type="hinge">'
                '<parent>a</parent><child>b</child></joint></model>'),
     'not supported: joint j of type hinge, which is held; remove that from the model'),
    ('<robot name="r">{}</robot>'.format(LINK.format('l')),
     'model m: link l can move but has no mass; add an <inertial>'),
    ('<robot name="r"><link name="world"><visual><geometry><mesh filename="package://a/b.dae"/>'
     '</geometry></visual></link></robot>', 'not supported: mesh package://a/b.dae'),
    ('<robot name="r"><link name="l">' + MASS + '<visual><geometry><mesh '
     'filename="package://a/b.dae"/>'
     '</geometry></visual></link></robot>', 'not supported: mesh package://a/b.dae')])
def test_refusals_are_one_line(text, words):
    assert words in refusal(model_file.read, text, 'm', nowhere, Report())


@pytest.mark.parametrize('uri', ['model://sun/', 'model://lamp'])
def test_only_a_light(tmp_path, uri):
    (tmp_path / 'model.sdf').write_text(SDF.format('<light name="lamp"/>'))
    text = SDF.format('<include><uri>{}</uri></include>'.format(uri))
    assert refusal(model_file.read, text, 'm', lambda uri: str(tmp_path), Report()) == (
        'model m: it has only lights, which every world here has already; add a model that has a '
        '<link>')


@pytest.mark.parametrize('name', ['m', 'ground_plane'])
def test_a_floor_is_a_model_like_others(name):
    text = SDF.format('<include><uri>model://ground_plane</uri></include>')
    first, plane = model_file.read(text, name, nowhere, Report())
    assert first.name == name and not first.model.is_plane and plane.model.is_plane


@pytest.mark.parametrize('name, words', [
    ('a\x01b', r"the name of a model, a\x01b, has the character '\x01', which XML does not allow; "
     'give a name without control characters'),
    ('a\0', r"the name of a model, a\x00, has the character '\x00', which XML does not allow"),
    ('a\ufffe', r"the name of a model, a\ufffe, has the character '\ufffe'"),
    ('a\udcff', r"the name of a model, a\udcff, has the character '\udcff'"),
    ('b' * 501, 'the name of a model that begins with {} has 501 bytes, allowed are 500; give a '
     'shorter name'.format('b' * 40)),
    *((given, 'model_name: got {!r}, allowed is a text that is not empty, without :: and control '
       'characters; give it another name'.format(given))
      for given in ('a::b', '::', '', ' ', 'a\tb', 'a\nb', 'a\x85'))])
@pytest.mark.parametrize('text', [
    SDF.format(MODEL), '<robot name="r"><link name="world"/></robot>'])
def test_names_that_are_refused(text, name, words):
    assert refusal(model_file.read, text, name, nowhere, Report()).startswith(words)


TEXTURE = '<material name="m"><texture filename="{}"/></material>'


@pytest.mark.parametrize('root', ['world', 'post'])
def test_textures_of_urdfs_are_found(tmp_path, root):
    (tmp_path / 'a.png').write_bytes(b'')
    text = '<robot name="r">{}</robot>'.format(LINK.format(root).replace(
        '</visual>', TEXTURE + '</visual>').replace('</link>', MASS + '</link>'))
    tree, = model_file.read(text.format('package://p/a.png'), 'm',
                            {'package://p/a.png': str(tmp_path / 'a.png')}.get, Report())
    look, = tree.model.links[0].looks
    assert look.material.texture == str(tmp_path / 'a.png')
    report = Report()
    model_file.read(text.format('package://p/b.png'), 'm', nowhere, report)
    assert report.lines() == [
        'model m: not found, drawn in another color: texture package://p/b.png; '
        'build the packages and source their setup.bash']


@pytest.mark.parametrize('text', [
    '<robot name="r"><link name="l">{}</link></robot>'.format(MASS.replace('"1"', '"1e-3"', 1)),
    SDF.format('<model name="o"><link name="l"><inertial><inertia><ixx>1e-3</ixx></inertia>'
               '</inertial></link></model>')])
def test_an_inertia_of_no_body_is_a_warning(text):
    report = Report()
    model_file.read(text, 'm', nowhere, report)
    assert report.lines() == []
    model_file.read(text.replace('1e-3', '3'), 'm', nowhere, report)
    line, = report.lines()
    assert line.startswith('model m: link l') and line.endswith('simulated with 1.33, 1.33, 2.67')


def test_unusual_names():
    for name in ('a b', 'a/b', '\u00e4\u2603', '%s<&">', '\U0001f916' * 125):
        tree, = model_file.read(SDF.format(MODEL), name, nowhere, Report())
        assert tree.model.name == name


@pytest.mark.parametrize('plugin, expected', [
    ('', False), ('<plugin filename="libgazebo_ros_p3d.so"/>', False),
    ('<plugin filename="libgazebo_ros_diff_drive.so"/>', True),
    # so that a wrong value is refused where the robot is read
    ('<plugin filename="libgazebo_ros_diff_drive.so"><wheelTorque>x</wheelTorque></plugin>',
     True)])
def test_a_robot_is_what_has_a_drive(plugin, expected):
    text = '<robot name="r"><link name="l"/><gazebo>{}</gazebo></robot>'.format(plugin)
    assert model_file.is_robot(text) == expected
