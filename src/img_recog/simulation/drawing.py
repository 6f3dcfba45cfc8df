"""A URDF made ready for PyBullet's window, which paints all shapes of a link in one color."""
import copy
import xml.etree.ElementTree as ElementTree

_INERTIA = {'ixx': '0', 'ixy': '0', 'ixz': '0', 'iyy': '0', 'iyz': '0', 'izz': '0'}


def split_links_by_color(urdf: str) -> str:
    """Return the URDF with each color of a link moved to a massless link fixed to it.

    What remains of the link is its inertia: collisions are not drawn and left out.
    """
    robot = ElementTree.fromstring(urdf)
    for link in robot.findall('link'):
        for collision in link.findall('collision'):
            link.remove(collision)
        painted = {}
        for visual in link.findall('visual'):
            link.remove(visual)
            material = visual.find('material')
            color = b'' if material is None else ElementTree.tostring(material).strip()
            if color not in painted:
                name = '{}_color_{}'.format(link.get('name'), len(painted))
                painted[color] = _fixed_link(robot, link.get('name'), name)
            painted[color].append(copy.deepcopy(visual))
    return ElementTree.tostring(robot, 'unicode')


def _fixed_link(robot, parent: str, name: str) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, 'joint', name=name + '_joint', type='fixed')
    ElementTree.SubElement(joint, 'parent', link=parent)
    ElementTree.SubElement(joint, 'child', link=name)
    link = ElementTree.SubElement(robot, 'link', name=name)
    # without one, PyBullet warns and assumes 1 kg
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'mass', value='0')
    ElementTree.SubElement(inertial, 'inertia', _INERTIA)
    return link
