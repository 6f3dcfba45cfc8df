"""Texts of SDF worlds and models, and how they are converted."""
import xml.etree.ElementTree as ElementTree

from img_recog.formats import sdf_models, world_file
from img_recog.formats.world_file import WorldFile
from img_recog.report import LEFT_OUT, Report
from img_recog.simulation.models import Figures, Models
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulated_model import SimulatedModel
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator

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


def box(x, y, z):
    """Return the geometry of a box of these sides in m."""
    return '<box><size>{} {} {}</size></box>'.format(x, y, z)


def ball(radius):
    """Return the geometry of a ball."""
    return '<sphere><radius>{}</radius></sphere>'.format(radius)


def link(name='l', pose='', geometry='', mass=1, moments=0.01, surface='', inside=''):
    """Return a link with a solid if it has a geometry; pose: six numbers, or the first of them;
    moments: of its inertia, in kg m2, or the one that all are.
    """
    ixx, iyy, izz = moments if isinstance(moments, tuple) else (moments,) * 3
    solid = geometry and '<collision name="c"><geometry>{}</geometry>{}</collision>'.format(
        geometry, surface)
    return (
        '<link name="{}"><pose>{}</pose><inertial><mass>{}</mass><inertia><ixx>{}</ixx><iyy>{}'
        '</iyy><izz>{}</izz></inertia></inertial>{}{}</link>').format(
            name, _pose(pose), mass, ixx, iyy, izz, solid, inside)


def model(name, *inside, pose='', static=False):
    """Return a model of these elements."""
    return '<model name="{}"><pose>{}</pose>{}{}</model>'.format(
        name, _pose(pose), '<static>1</static>' if static else '', ''.join(inside))


def body(name, pose, geometry, static=False, **more):
    """Return a model of one link `l`; more: of the link."""
    return model(name, link(geometry=geometry, **more), pose=pose, static=static)


def _pose(text):
    return ' '.join((text + ' 0' * 6).split()[:6])


def world(*models, name='hall.world'):
    """Return a world with these models."""
    file = world_file.read(name, {}, read_file=lambda path: sdf(*models))
    return World(PhysicsSettings(), file, connect(), make=SimulatedModel)


def simulated(*models, velocities=()):
    """Return a simulator of these models; velocities: of models at the start, m/s and rad/s."""
    simulator = Simulator(world(*models))
    all_models = Models(simulator)
    for name, (linear, angular) in dict(velocities).items():
        all_models.set_state(name, all_models.state(name)._replace(linear=linear, angular=angular))
    return simulator


def figures(simulator, seconds):
    """Return the figures of a simulator after a time."""
    simulator.advance(round(seconds / simulator.world.step_s))
    return Figures(simulator)


def convert(*inside, version=(1, 6), problems=(), findings=()):
    """Return the trees of a model of these elements; problems: the names of what is left out;
    findings: what its reader finds."""
    model = ElementTree.fromstring('<model name="m">{}</model>'.format(''.join(inside)))
    found = Report()
    trees = sdf_models.trees(model, version, lambda uri: None, found)
    assert found.of(LEFT_OUT) == list(problems)
    assert [each.text() for each in found.findings if each.kind != LEFT_OUT] == list(findings)
    return trees


def load(*inside, **more):
    """Return a world with such a model."""
    return World(PhysicsSettings(), WorldFile('w', tuple(convert(*inside, **more))), connect())
