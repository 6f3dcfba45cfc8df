"""Texts of SDF worlds and models, and how they are converted."""
import xml.etree.ElementTree as ElementTree

from img_recog.formats import sdf_models
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings

BOX = '<{0} name="s">{1}<geometry><box><size>{2}</size></box></geometry></{0}>'
INERTIAL = ('<inertial><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz>'
            '<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>')
SHELF = ('<model name="shelf"><static>true</static><pose>1 2 1 0 0 0</pose><link name="l">'
         + INERTIAL + BOX.format('collision', '', '0.8 0.8 0.2') + '</link></model>')
CRATE = ('<model name="crate"><pose>{}</pose><link name="l">' + INERTIAL
         + BOX.format('collision', '', '0.2 0.2 0.2') + '</link></model>')
BUILT_IN = ('<include><uri>model://ground_plane</uri></include>'
            '<include><uri>model://sun</uri></include>')


def sdf(*models, version='1.6'):
    """Return a world with these models."""
    return '<sdf version="{}"><world name="default">{}</world></sdf>'.format(
        version, ''.join(models))


def convert(*inside, version=(1, 6), problems=(), findings=()):
    """Return the trees of a model of these elements; problems: the names of what is left out;
    findings: what its reader finds."""
    model = ElementTree.fromstring('<model name="m">{}</model>'.format(''.join(inside)))
    found = Problems()
    trees = sdf_models.trees(model, version, lambda uri: None, found)
    assert found.names == tuple(problems)
    assert tuple(finding.text() for finding in found.findings) == tuple(findings)
    return trees


def load(*inside, **more):
    """Return a world with such a model."""
    return World(PhysicsSettings(), WorldFile('w', tuple(convert(*inside, **more))), connect())
