"""What of a file is not done as asked, and what is misspelt."""
import re
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.checks import world_check
from img_recog.formats import schema
from img_recog.formats.audit import audit
from img_recog.report import Report
from img_recog_helpers.pages import tool

MODEL = '<sdf version="1.6"><world name="w"><model name="m">{}</model></world></sdf>'
LINK = MODEL.format('<link name="l">{}</link>')
ROBOT = '<robot name="r"><link name="l">{}</link>{}</robot>'


def said(text):
    report = Report()
    report.extend(audit(ElementTree.fromstring(text)))
    return [(each.kind, each.text()) for each in report.findings]


@pytest.mark.parametrize('text, state, words', [
    (MODEL.replace('model', 'modle').format(''), 'not known', '<modle> of world w'),
    (LINK.format('<colision name="c"/>'), 'not known', '<colision> of model m link l'),
    (MODEL.format('<static>ture</static>'), 'not known',
     '<static>ture</static>, which is neither true nor false, of world w model m'),
    (MODEL.replace('name="m"', 'nmae="x" name="m"').format(''), 'not known',
     'attribute nmae of <model> of world w model m'),
    (ROBOT.format('<inertial><origin xzy="0 0 1"/></inertial>', ''), 'not known',
     'attribute xzy of <origin> of robot r link l'),
    (LINK.format('<projector/>'), 'not simulated', '<projector> of model m link l'),
    (LINK.format('<pose degres="1">0 0 0 0 0 0</pose>'), 'not known',
     'attribute degres of <pose> of model m link l'),
    (LINK.format('<collision name="c"><surface><friction><ode><mu>1</mu><slip1>2</slip1></ode>'
                 '</friction></surface></collision>'),
     'not simulated', '<slip1> of link l collision c'),
    (LINK.format('<collision name="c"><surface><friction><ode><mu>-0.5</mu><mu2>0</mu2></ode>'
                 '</friction></surface></collision>'), 'not used',
     '<mu>-0.5</mu>, which means unlimited friction in Gazebo, of link l collision c'),
    (ROBOT.format('', '<gazebo reference="l"><mu1>-1</mu1></gazebo>'), 'not used',
     '<mu1>-1</mu1>, which means unlimited friction in Gazebo, of robot r gazebo l'),
    (MODEL.format('<link name="a"/><link name="a"/>'), 'not unique',
     'the name link a of world w model m'),
    (LINK.format('<pose>1 0 0 0 0 0</pose><pose>2 0 0 0 0 0</pose>'), 'not used',
     'second <pose> of model m link l'),
    (LINK.format('<visual name="v"><geometry><box/><sphere/></geometry></visual>'), 'not used',
     'second shape <sphere> of link l visual v'),
    (MODEL.format('<link/>'), 'not known', '<link> without a name of world w model m'),
    (MODEL.replace('</world>', '</world><world name="v"/>'), 'not used',
     'second world v of the file'),
    (ROBOT.format('', '<gazebo><plugin filename="libgazebo_ros_diff_drive.so"><leftJoint>j'
                  '</leftJoint><wheelSeperation>1</wheelSeperation></plugin></gazebo>'),
     'not known', '<wheelSeperation> of robot r plugin libgazebo_ros_diff_drive.so'),
    (MODEL.format('<plugin filename="libgazebo_ros_diff_drive.so"><topic/></plugin>'),
     'not known', '<topic> of model m plugin libgazebo_ros_diff_drive.so'),
    (MODEL.format('<plugin filename="libgazebo_ros_difdrive.so"><topic/></plugin>'), 'not known',
     'plugin libgazebo_ros_difdrive.so (did you mean libgazebo_ros_diff_drive.so?) of world w '
     'model m'),
    (ROBOT.format('', '<gazebo><plugin filename="libgazebo_ros_difdrive.so"/></gazebo>'),
     'not known', 'plugin libgazebo_ros_difdrive.so (did you mean libgazebo_ros_diff_drive.so?) '
     'of robot r'),
    (ROBOT.format('', '<gazebo reference="l"><sensor name="s" type="ray"><plugin '
                  'filename="libRayPlugin.so"/></sensor></gazebo>'), 'not known',
     'plugin libRayPlugin.so (did you mean libgazebo_ros_laser.so?) of gazebo l sensor s'),
    (ROBOT.format('<visaul/>', ''), 'not known', '<visaul> of robot r link l'),
    (ROBOT.format('', '<gazebo reference="l"><kinematic>true</kinematic></gazebo>'),
     'not simulated', '<kinematic> of robot r gazebo l'),
    (ROBOT.format('', '<gazebo reference="l"><laserRetro>2</laserRetro></gazebo>'),
     'not simulated', '<laserRetro> of robot r gazebo l')])
def test_what_is_said(text, state, words):
    assert said(text) == [(state, words)]


@pytest.mark.parametrize('text', [
    LINK.format('<gravity>0</gravity><kinematic>true</kinematic><self_collide>1</self_collide>'
                '<velocity_decay><linear>1</linear><angular/></velocity_decay>'),
    MODEL.format('<joint name="j"><axis><dynamics><spring_stiffness>2</spring_stiffness>'
                 '</dynamics><limit><effort>1</effort></limit></axis></joint>'),
    ROBOT.format('', '<gazebo reference="l"><kinematic>false</kinematic></gazebo>'),
    LINK.format('<collision name="c"><surface><friction><ode><mu>0.5</mu><mu2>0.50</mu2><fdir1>0 '
                '0 0</fdir1></ode></friction><contact><ode><kp>1</kp></ode></contact></surface>'
                '</collision>'),
    LINK.format('<!-- a comment --><gz:system xmlns:gz="http://gazebosim.org/schema"/>'),
    MODEL.format('<plugin name="p" filename="f"><anything><colision/></anything></plugin>'
                 ).replace('model', 'gui').replace('name="m"', ''),
    '<sdf><world name="w"><scene><ambient>0.4 0.4 0.4</ambient><shadows>true</shadows></scene>'
    '</world></sdf>',
    ROBOT.format('', '<gazebo reference="l"><mu1>0.1</mu1><mu2>0.1</mu2><kp>5</kp></gazebo>'),
    *(ROBOT.format('', '<gazebo><plugin name="p" filename="{}"><leftJoint>a</leftJoint></plugin>'
                   '</gazebo>'.format(name))
      for name in ('f', 'libgazebo_ros_ft_sensor.so', 'libgazebo_ros_p3d.so',
                   'libgazebo_ros_velodyne_laser.so'))])
def test_nothing_is_said_of_what_is_done_or_changes_nothing(text):
    assert said(text) == []


def test_places_are_counted():
    links = ''.join('<link name="l{}"><projector/></link>'.format(number)
                    for number in range(5))
    assert said(MODEL.format(links)) == [(
        'not simulated', '<projector> of model m link l0, model m link l1, model m link l2 and 2 '
        'more')]


@pytest.mark.parametrize('table', [schema.SDF, schema.URDF])
def test_each_element_is_in_one_field(table):
    for path, row in table.items():
        words = [re.split('[:=]', word)[0] for text in row[:4] for word in text.split()]
        assert sorted(set(words)) == sorted(words), path


# doc/elements.md is the second place
@pytest.mark.parametrize('row, rows', [
    ({'simulated': 'wobble:bool'}, [
        ('not known', '<wobble>2</wobble>, which is neither true nor false,')]),
    ({'simulated': 'wobble'}, []), ({'drawn': 'wobble'}, []), ({'no_effect': 'wobble'}, []),
    ({'not_simulated': 'wobble=2'}, []), ({'not_simulated': 'wobble'}, [
        ('not simulated', '<wobble>')])])
def test_an_element_is_added_in_its_row_alone(monkeypatch, tmp_path, row, rows):
    before = schema.SDF['link']
    changed = before._replace(**{name: '{} {}'.format(getattr(before, name), words)
                                 for name, words in row.items()})
    monkeypatch.setitem(schema.SDF, 'link', changed)
    schema.row_of.cache_clear()
    path = tmp_path / 'w.sdf'
    path.write_text(LINK.format('<wobble>2</wobble>'))
    try:
        found = world_check.check(str(path)).rows
        assert [each[:3] for each in found if 'wobble' in each.what] == [
            (state, what, 'model m link l') for state, what in rows]
        page = tool('generated_pages').written()['doc/elements.md']
        assert page.count('`wobble') == 1
    finally:
        schema.row_of.cache_clear()
