"""Small robots with wheels, and how fast they drive."""
import math

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import world_file
from img_recog.simulation import assembly
from img_recog.simulation.configured_model import from_urdf
from img_recog.simulation.simulation_settings import PhysicsSettings

CYLINDER = '<cylinder radius="{radius}" length="0.04"/>'
INERTIAL = ('<inertial>{origin}<mass value="{mass}"/><inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" '
            'iyz="0" izz="{i}"/></inertial>')
JOINT = ('<joint name="{name}_joint" type="{type}"><parent link="base_link"/>'
         '<child link="{name}"/><origin xyz="{x} {y} {z}" rpy="{roll} 0 0"/><axis xyz="0 0 1"/>'
         '</joint>')
LINK = ('<link name="{name}">' + INERTIAL + '<collision>{origin}<geometry>{shape}</geometry>'
        '</collision></link>')
# of a commanded turn: like in Gazebo, wheels of this width, 0.4 m apart, roll on their outer edges
TURN_SHARE = 0.4 / 0.44
MU = '<gazebo reference="{}"><mu1>0</mu1><mu2>0</mu2></gazebo>'


def robot(more='', rows=(0.0,), separation=0.4, radius=0.1, shape=CYLINDER, mass=5.0,
          casters=None):
    """Return the URDF of a base with wheels that touch the floor.

    more: elements; rows: where wheels are along x, in m; their links are left_0, right_0, left_1
    and so on, and their joints end in _joint. casters: where spheres without friction are along
    x, by default on both ends if there is one row.
    """
    low = '<origin xyz="0 0 {}"/>'.format(radius)
    parts = [LINK.format(name='base_link', mass=mass, i=mass / 20, origin=low,
                         shape='<box size="0.3 0.2 {}"/>'.format(radius))]
    for number, x in enumerate(rows):
        for side, y in (('left', separation / 2), ('right', -separation / 2)):
            name = '{}_{}'.format(side, number)
            parts.append(LINK.format(name=name, mass=0.2, i=0.001, origin='',
                                     shape=shape.format(radius=radius)))
            parts.append(JOINT.format(name=name, type='continuous', x=x, y=y, z=radius,
                                      roll=-math.pi / 2))
    if casters is None:
        casters = (0.13, -0.13) if len(rows) == 1 else ()
    for number, x in enumerate(casters):
        name = 'caster_{}'.format(number)
        parts.append(LINK.format(name=name, mass=0.01, i=1e-6, origin='',
                                 shape='<sphere radius="0.02"/>'))
        parts.append(JOINT.format(name=name, type='fixed', x=x, y=0, z=0.02, roll=0))
        parts.append(MU.format(name))
    return '<robot name="wheeled">{}{}</robot>'.format(''.join(parts), more)


def plugin(library, **tags):
    """Return a <gazebo> element with a plugin and its tags."""
    return '<gazebo><plugin name="drive" filename="lib{}.so">{}</plugin></gazebo>'.format(
        library, ''.join('<{0}>{1}</{0}>'.format(*tag) for tag in tags.items()))


def controllers(rows=1, **parameters):
    """Return the parameters of a diff_drive_controller `base` of so many rows of wheels."""
    names = {side + '_wheel': ['{}_{}_joint'.format(side, row) for row in range(rows)]
             for side in ('left', 'right')}
    return {'base': {'type': 'diff_drive_controller/DiffDriveController', **names, **parameters}}


def wheel_mesh(radius, middle=(0.0, 0.0), width=0.04, corners=36):
    """Return the text of an OBJ: a wheel about z, whose middle may be beside the axis."""
    angles = [2 * math.pi * number / corners for number in range(corners)]
    lines = ['v {} {} {}'.format(middle[0] + radius * math.cos(angle),
                                 middle[1] + radius * math.sin(angle), z)
             for z in (-width / 2, width / 2) for angle in angles]
    rims = [[first + number for number in range(corners)] for first in (1, corners + 1)]
    faces = [rims[0][::-1], rims[1]]
    for number in range(corners):
        after = (number + 1) % corners
        faces.append([rims[0][number], rims[0][after], rims[1][after], rims[1][number]])
    return '\n'.join(lines + ['f ' + ' '.join(map(str, face)) for face in faces])


def source(urdf, controllers=(), find_mesh=lambda uri: None):
    """Return what the text of a URDF gives; controllers: those on the parameter server."""
    return from_urdf(urdf, PhysicsSettings().step_s, find_mesh, 'robot.urdf', SENSORS,
                     lambda namespace: dict(controllers))


def assembled(urdf, controllers=(), find_mesh=lambda uri: None):
    """Return the assembly of a robot at the origin of an empty world."""
    return assembly.build(PhysicsSettings(world='empty'), world_file.read('empty', {}),
                          [source(urdf, controllers, find_mesh)])


def velocity(simulator, forward=0.0, turn=0.0, left=0.0, settle_s=0.8, seconds=0.5):
    """Return how fast the robot drives on a command: forward and left in m/s, turn in rad/s."""
    robot = simulator.robots[0]
    way, turned = [0.0, 0.0], 0.0
    for period in range(round((settle_s + seconds) / 0.05)):
        robot.command(forward, turn, left)
        before = robot.body.motion()
        simulator.advance(50)
        now = robot.body.motion()
        if period < round(settle_s / 0.05):
            continue
        step = math.remainder(now.yaw - before.yaw, 2 * math.pi)
        x, y = (now.position - before.position)[:2]
        yaw = before.yaw + step / 2
        way[0] += x * math.cos(yaw) + y * math.sin(yaw)
        way[1] += y * math.cos(yaw) - x * math.sin(yaw)
        turned += step
    return way[0] / seconds, way[1] / seconds, turned / seconds
