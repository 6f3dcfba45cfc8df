"""DAE files that would crash PyBullet are refused before it reads them."""
from xml.parsers import expat

import pytest

from img_recog.simulation.bodies import loading
from img_recog.simulation.descriptions import dae_check
from img_recog.simulation.descriptions.dae_check import DamagedMesh

ASSET = '<asset><unit meter="1" name="m"/><up_axis>Z_UP</up_axis></asset>'
VERTEX = '<input semantic="VERTEX" source="#v" offset="0"/>'
NORMAL = '<input semantic="NORMAL" source="#s" offset="1"/>'
SCENE = '<instance_visual_scene url="#vs"/>'
GEOMETRY = '<instance_geometry url="#g"/>'
DAE = """<?xml version="1.0"?>
<COLLADA version="1.4.1">""" + ASSET + """<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="sa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#sa" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="2">""" + VERTEX + """<p>0 1 2 1 3 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="vs"><node id="n">""" + GEOMETRY + """
</node></visual_scene></library_visual_scenes><scene>""" + SCENE + '</scene></COLLADA>'
ROBOT = ('<robot name="r"><link name="l"><collision concave="yes"><geometry><mesh filename="{}"/>'
         '</geometry></collision></link></robot>')


def check(tmp_path, text):
    path = tmp_path / 'a.dae'
    path.write_text(text)
    dae_check.check(str(path))
    return path


@pytest.mark.parametrize('old, new', [
    ('', ''), (ASSET, '<asset/>'), ('triangles', 'polylist'), (SCENE, ''),
    ('<mesh>', '<mesh><!-- a comment -->'), ('1 3 2<', '1 3 2\n<'), ('meter="1"', 'meter="0.01"'),
    (VERTEX + '<p>0 1 2 1 3 2<', VERTEX + NORMAL + '<p>0 0 1 1 2 2 1 0 3 3 2 1<'),
    (GEOMETRY, '<translate>1 2 3</translate>' + GEOMETRY + '<node id="b"/>')])
def test_complete_files(tmp_path, old, new):
    path = check(tmp_path, DAE.replace(old, new))
    if new:
        loading.load_urdf(ROBOT.format(path), loading.connect(), fixed=True)


@pytest.mark.parametrize('old, new, words', [
    (ASSET, '', 'its <COLLADA> has no <asset>'), (' meter="1"', '', 'a <unit> in it has no meter'),
    ('meter="1"', 'meter="0"', 'its <unit> has the length 0'),
    ('Z_UP', '', 'a <up_axis> in it has no'),
    ('library_geometries', 'library', 'its <COLLADA> has no <library_geometries>'),
    ('<geometry id="g">', '<geometry>', 'a <geometry> in it has no id'),
    ('<source id="s">', '<source>', 'a <source> in it has no id'),
    ('vertices', 'points', 'its <mesh> has no <vertices>'),
    ('<vertices id="v">', '<vertices>', 'a <vertices> in it has no id'),
    ('source="#s"', 'source="#t"', 'it has no <source> t'),
    ('semantic="POSITION" source="#s"', 'semantic="POSITION"', 'a <input> in it has no source'),
    ('POSITION', 'NORMAL', 'a <triangles> has no positions'),
    ('source="#v"', 'source="#w"', 'it has no <vertices> w'),
    (VERTEX, '', 'a <triangles> has no positions'),
    (' offset="0"', '', 'a <input> in it has no offset'),
    ('offset="0"', 'offset="-1"', '<input offset> in it is -1, expected 0 to 100'),
    ('offset="0"', 'offset="1"', '<p> of a <triangles> has 6 numbers, expected 12'),
    ('<triangles count="2">', '<triangles>', 'a <triangles> in it has no count'),
    ('count="2"', 'count="-1"', '<triangles count> in it is -1, expected 0 to 5000000'),
    ('count="2"', 'count="3"', '<p> of a <triangles> has 6 numbers, expected 9'),
    ('<p>0 1 2 1 3 2</p>', '', 'its <triangles> has no <p>'),
    ('0 1 2 1 3 2', '', 'a <p> in it has no text'),
    ('<p>0', '<p><!-- a -->0', 'a <p> in it has more than text'),
    ('1 3 2', '1 <!-- a -->3 2', 'a <p> in it has more than text'),
    ('1 3 2', '1 4 2', 'a triangle refers to number 4 of 4, the first is 0'),
    ('1 3 2', '1 -1 2', 'a triangle refers to number -1 of 4'),
    ('1 3 2', '1 x 2', '<p> of a <triangles> has something that is not a whole number'),
    (VERTEX + '<p>0 1 2 1 3 2<', VERTEX + NORMAL + '<p>0 0 1 1 2 2 1 0 3 4 2 1<',
     'a triangle refers to number 4 of 4'),
    ('0 0 0 1<', '0 0 0<', 'a <float_array> has 11 numbers, expected 12'),
    ('0 0 0 1<', '0 0\t0 1<', 'something that is not a finite number'),
    ('0 0 0 1<', '0 0 0 nan<', '<float_array> has something that is not a finite number'),
    ('0 0 0 1<', '0 0 0 1e39<', '<float_array> has something that is not a finite number'),
    (' count="12"', '', 'a <float_array> in it has no count'),
    ('technique_common', 'technique', 'its <source> has no <technique_common>'),
    ('accessor', 'access', 'its <technique_common> has no <accessor>'),
    ('<visual_scene id="vs">', '<visual_scene>', 'a <visual_scene> in it has no id'),
    (SCENE, '<instance_visual_scene/>', 'a <instance_visual_scene> in it has no url'),
    (GEOMETRY, '<instance_geometry url=""/>', 'a <instance_geometry> in it has an empty url'),
    (GEOMETRY, '<scale>1 inf 1</scale>', '<scale> has something that is not a finite number'),
    ('</node>', '</node><rotate>0 0 1 90</rotate>', 'a <rotate> follows a <node>'),
    ('<p>0 1 2 1 3 2</p>', '<p><![CDATA[0 1 2 1 3 2]]></p>', 'it has a CDATA section'),
    (GEOMETRY, '<node>' * 99 + '</node>' * 99, 'it is nested more than 100 levels deep')])
def test_damaged_files(tmp_path, old, new, words):
    assert old in DAE
    with pytest.raises(DamagedMesh) as error:
        check(tmp_path, DAE.replace(old, new))
    assert words in str(error.value)


def test_too_many_triangles_in_total(tmp_path, monkeypatch):
    monkeypatch.setattr(dae_check, 'MAX_TRIANGLES', 5)
    check(tmp_path, DAE.replace(GEOMETRY, GEOMETRY * 2))
    with pytest.raises(DamagedMesh, match='it has 6 triangles, more than 5'):
        check(tmp_path, DAE.replace(GEOMETRY, GEOMETRY * 3))


def test_every_truncated_file_is_refused(tmp_path):
    for length in range(len(DAE)):
        with pytest.raises((DamagedMesh, expat.ExpatError)):
            check(tmp_path, DAE[:length])
