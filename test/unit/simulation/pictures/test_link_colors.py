"""Each color on a separate link, and nothing lost."""
import xml.etree.ElementTree as ElementTree

from img_recog.simulation.descriptions.description import parse
from img_recog.simulation.pictures.link_colors import split_links_by_color
from img_recog_testing.robots import WORLDS, burger


def painted(urdf):
    return ElementTree.fromstring(split_links_by_color(urdf))


def test_every_link_has_one_color_and_every_shape_is_kept():
    for urdf in (parse(burger()).urdf, open(WORLDS['turtlebot3_world']).read()):
        robot = painted(urdf)
        for link in robot.findall('link'):
            colors = {ElementTree.tostring(visual.find('material')).strip()
                      for visual in link.findall('visual')}
            assert len(colors) <= 1
        before = len(list(ElementTree.fromstring(urdf).iter('visual')))
        assert len(list(robot.iter('visual'))) == before > 50


def test_joints_of_the_robot_keep_their_names_and_masses():
    urdf = parse(burger()).urdf
    names = {joint.get('name') for joint in painted(urdf).findall('joint')}
    assert {'wheel_left_joint', 'wheel_right_joint'} <= names
    before, after = (sum(float(mass.get('value')) for mass in robot.iter('mass'))
                     for robot in (ElementTree.fromstring(urdf), painted(urdf)))
    assert before == after


def test_added_links_have_no_mass_and_no_inertia_and_are_fixed():
    robot = painted('<robot name="r"><link name="a"><inertial><mass value="1"/></inertial>'
                    '<visual><material name="m"/></visual><visual/><visual><material name="m"/>'
                    '</visual><collision/></link></robot>')
    assert [link.get('name') for link in robot.findall('link')] == ['a', 'a_color_0', 'a_color_1']
    assert [len(link.findall('visual')) for link in robot.findall('link')] == [0, 2, 1]
    assert robot.find('.//collision') is None and robot.get('name') == 'r'
    for number, joint in enumerate(robot.findall('joint')):
        name = 'a_color_{}'.format(number)
        assert joint.attrib == {'name': name + '_joint', 'type': 'fixed'}
        assert joint.find('parent').attrib == {'link': 'a'}
        assert joint.find('child').attrib == {'link': name}
    for link in robot.findall('link')[1:]:
        assert link.find('inertial/mass').attrib == {'value': '0'}
        assert link.find('inertial/inertia').attrib == dict.fromkeys(
            ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), '0')
    assert len(robot.findall('joint')) == 2
