"""Each color on a separate link, and nothing lost."""
import xml.etree.ElementTree as ElementTree

from img_recog.simulation.description import parse
from img_recog.simulation.drawing import split_links_by_color
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
