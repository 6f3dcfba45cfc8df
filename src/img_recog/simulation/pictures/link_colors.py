"""A URDF prepared for PyBullet's window, which paints all shapes of a link in one color."""
import copy
import xml.etree.ElementTree as ElementTree
from typing import Dict

from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.descriptions.urdf_elements import add_massless


def split_links_by_color(urdf: str) -> str:
    """Return the URDF with each color of a link moved to a massless link fixed to it.

    Inertias stay where they are; collision shapes are removed, since they are not drawn.
    """
    robot = ElementTree.fromstring(urdf)
    for link in robot.findall('link'):
        for collision in link.findall('collision'):
            link.remove(collision)
        links: Dict[bytes, ElementTree.Element] = {}
        for visual in link.findall('visual'):
            link.remove(visual)
            material = visual.find('material')
            color = b'' if material is None else ElementTree.tostring(material).strip()
            if color not in links:
                links[color] = _add_fixed_link(robot, name_of(link), len(links))
            links[color].append(copy.deepcopy(visual))
    return ElementTree.tostring(robot, 'unicode')


def _add_fixed_link(robot: ElementTree.Element, parent: str, number: int) -> ElementTree.Element:
    name = '{}_color_{}'.format(parent, number)
    joint = ElementTree.SubElement(robot, 'joint', name=name + '_joint', type='fixed')
    ElementTree.SubElement(joint, 'parent', link=parent)
    ElementTree.SubElement(joint, 'child', link=name)
    link = ElementTree.SubElement(robot, 'link', name=name)
    add_massless(link)
    return link
