"""What slides, sticks and turns, against what the same does in Gazebo 11 (recorded figures)."""
import math
import re

import pybullet
import pytest

from img_recog import rotations
from img_recog.simulation.physics.client import link_indices
from img_recog.simulation.physics.tires import ACROSS
from img_recog_helpers import sdf
from img_recog_helpers.wheeled import assembled, plugin, robot, velocity

SKID = plugin('gazebo_ros_skid_steer_drive', leftFrontJoint='left_0_joint', torque=20,
              leftRearJoint='left_1_joint', rightFrontJoint='right_0_joint',
              rightRearJoint='right_1_joint', robotBaseFrame='base_link')
DRIVE = plugin('gazebo_ros_diff_drive', leftJoint='left_0_joint', rightJoint='right_0_joint',
               wheelTorque=20)
FLAT = dict(mass=1, moments=(0.00833, 0.00833, 0.015))
X, Y = '<fdir1>1 0 0</fdir1>', '<fdir1>0 1 0</fdir1>'


def mu(first, second=None, more=''):
    return '<surface><friction><ode><mu>{}</mu>{}{}</ode></friction></surface>'.format(
        first, '' if second is None else '<mu2>{}</mu2>'.format(second), more)


def box(friction, pose='0 0 0.05', name='b', size=(0.3, 0.3, 0.1), static=False):
    return sdf.body(name, pose, sdf.box(*size), static, surface=friction, **FLAT)


def parts(name, pose, *collisions, static=False):
    """Return a model of 1 kg with boxes: each the place of its middle, its size and surface."""
    return sdf.model(name, sdf.link(**FLAT, inside=''.join(
        '<collision name="{}"><pose>{} 0 0 0</pose><geometry>{}</geometry>{}</collision>'.format(
            number, place, sdf.box(*size), surface)
        for number, (place, size, surface) in enumerate(collisions))), pose=pose, static=static)


def place(models, seconds, velocity=()):
    """Return where a box b is after a time; velocity: of it at the start."""
    velocities = {'b': (velocity, (0, 0, 0))} if velocity else {}
    simulator = sdf.simulated(sdf.BUILT_IN, models, velocities=velocities)
    return sdf.figures(simulator, seconds).links()['b::l'][:3]


@pytest.mark.parametrize('degrees, slope, sliding, x', [
    (20, 1, 0.3, 0.6403), (20, 0.3, 1, 0.6403), (20, 0.3, 0.3, 0.6403), (30, 0.5, 0.4, 1.4924),
    (30, 0.4, 0.5, 1.4924), (20, 1, 0.5, 0.0171), (50, 3, 1, 0.9124), (50, 3, 1.5, 0.0413),
    (50, 3, 3, 0.0383), (50, 1, 3, 0.9124)])
def test_of_two_surfaces_the_lower_coefficient_counts(degrees, slope, sliding, x):
    angle = math.radians(degrees)
    poses = ['{} 0 {} 0 {}'.format(away * math.sin(angle), 5 + away * math.cos(angle), angle)
             for away in (-0.05, 0.05)]
    models = (box(mu(slope, slope), poses[0], 'slope', (20, 0.8, 0.1), static=True)
              + box(mu(sliding, sliding), poses[1]))
    assert place(models, 1.5)[0] == pytest.approx(x, abs=0.01)


CUBE = 0.3, 0.3, 0.1
LANES = parts('floor', '0 0 0.05', ('0 1 0', (8, 1.8, 0.1), mu(0.1, 0.1)),
              ('0 -1 0', (8, 1.8, 0.1), mu(0.6, 0.6)), static=True)
CUBES = ('0 0 0', CUBE, mu(0.1, 0.1)), ('0 0 0.1', CUBE, mu(0.6, 0.6))
DIAGONAL = 2.1213203


@pytest.mark.parametrize('models, velocity, x_y', [
    (box(mu(0.3, 0.3)), (3, 0, 0), (1.5291, 0)),
    (box(mu(0.3, 0.3)), (DIAGONAL, DIAGONAL, 0), (0.7642, 0.7642)),
    # without a direction, mu is along y and mu2 along x; mu2 is 1 by default
    (box(mu(0.1, 0.6)), (2, 0, 0), (0.3391, 0)), (box(mu(0.6, 0.1)), (2, 0, 0), (2.039, 0)),
    (box(mu(0.1, 0.6)), (0, 2, 0), (0, 2.039)), (box(mu(0.1)), (2, 0, 0), (0.203, 0)),
    (box(mu(0.1)), (0, 2, 0), (0, 2.039)), (box(mu(0.1, 0.6, X)), (2, 0, 0), (2.039, 0)),
    (box(mu(0.1, 0.6, Y)), (2, 0, 0), (0.3391, 0)),
    # each collision of a link has its own
    (box(mu(1, 1), '0 1 0.15') + LANES, (2, 0, 0), (2.039, 1)),
    (box(mu(1, 1), '0 -1 0.15') + LANES, (2, 0, 0), (0.3391, -1)),
    (parts('b', '0 0 0.05', *CUBES), (2, 0, 0), (2.039, 0)),
    (parts('b', '0 0 0.15 3.14159265', *CUBES), (2, 0, 0), (0.3391, 0)),
    (parts('b', '0 0 0.15', ('0 0 0', CUBE, mu(1, 1)), ('0 0 -0.1', CUBE, mu(0.1, 0.6, X))),
     (2, 0, 0), (2.039, 0))])
def test_how_far_a_box_slides(models, velocity, x_y):
    assert place(models, 2.0, velocity)[:2] == pytest.approx(x_y, rel=0.02, abs=0.006)


def test_a_new_body_does_not_have_the_friction_of_a_removed_one():
    floor = box(mu(0.5, 0.5), name='floor', size=(8, 8, 0.1), static=True)
    simulator = sdf.simulated(sdf.BUILT_IN, floor + box(mu(1, 1), '0 0 0.15'))
    simulator.advance(20)
    simulator.world.remove(simulator.world.models[-1])
    # PyBullet gives it the number of the removed one
    simulator.world.load(sdf.world(box(mu(0.5, 0.5), '0 0 0.15')).trees)
    body, = simulator.world.models[-1].bodies
    body.set_velocity((2, 0, 0), (0, 0, 0))
    assert sdf.figures(simulator, 2.0).links()['b::l'][0] == pytest.approx(0.408, rel=0.02)


def test_each_collision_of_a_link_has_its_bitmask():
    bits = '<surface><contact><collide_bitmask>{}</collide_bitmask></contact></surface>'.format
    models = parts('b', '0 0 0.45', ('0 0 0', CUBE, bits('0x2')), ('0 0 -0.1', CUBE, bits('0x4')))
    shelf = parts('shelf', '0 0 0.1', ('0 0 0', (1, 1, 0.1), bits('0x2')), static=True)
    assert place(models + shelf, 2.0)[2] == pytest.approx(0.2, abs=0.002)


def with_tags(urdf, reference, tags):
    return urdf.replace('</robot>', '<gazebo reference="{}">{}</gazebo></robot>'.format(
        reference, tags))


def without_mu(urdf):
    """Return a robot whose casters have the default friction."""
    return re.sub('<gazebo reference="caster.*?</gazebo>', '', urdf)


def turn_rate(urdf, heading):
    simulator = assembled(urdf)
    body = simulator.robots[0].body
    body.place(body.pose()._replace(orientation=rotations.of_yaw(heading)))
    return velocity(simulator, 0.0, 1.5, settle_s=0.5, seconds=1.0)[2]


ONE_CASTER = robot(DRIVE, casters=(-0.13,))


@pytest.mark.parametrize('urdf', [robot(DRIVE), ONE_CASTER, without_mu(ONE_CASTER)])
def test_casters_do_not_keep_a_robot_from_turning(urdf):
    assert turn_rate(urdf, 0.0) == pytest.approx(1.3637, rel=0.02)


@pytest.mark.parametrize('casters', [(0.17, -0.17), (-0.17,)])
def test_casters_of_default_friction_do_not_hold_a_robot(casters):
    urdf = without_mu(robot(DRIVE, casters=casters)).replace(
        '<sphere radius="0.02"/>', '<sphere radius="0.05"/>').replace(' 0 0.02"', ' 0 0.05"')
    # Gazebo: 0.4924
    assert velocity(assembled(urdf), 0.5)[0] == pytest.approx(0.4924, rel=0.02)


# Gazebo: means over the headings 0, 0.4 and 0.785
@pytest.mark.parametrize('half_base, rate', [(0.1, 1.155), (0.15, 0.934)])
def test_how_fast_a_skid_steered_robot_turns_on_the_mean(half_base, rate):
    urdf = robot(SKID, rows=(half_base, -half_base))
    rates = [turn_rate(urdf, heading) for heading in (0.0, 0.4, 0.785)]
    assert sum(rates) / 3 == pytest.approx(rate, rel=0.22)


@pytest.mark.parametrize('half_base, tags, rate', [
    (0.15, '<mu1>1</mu1><mu2>1</mu2><fdir1>0 0 1</fdir1>', 1.344),
    (0.25, '<mu1>1</mu1><mu2>1</mu2><fdir1>0 0 1</fdir1>', 0.0),
    (0.25, '<mu1>0.2</mu1><mu2>1</mu2><fdir1>0 0 1</fdir1>', 1.479),
    (0.15, '<mu1>1</mu1><mu2>1</mu2><fdir1>1 0 0</fdir1>', 1.294),
    (0.25, '<mu1>1</mu1><mu2>0.3</mu2><fdir1>1 0 0</fdir1>', 1.381)])
def test_a_direction_of_friction_turns_with_the_wheels(half_base, tags, rate):
    urdf = robot(SKID, rows=(half_base, -half_base))
    for wheel in ('left_0', 'right_0', 'left_1', 'right_1'):
        urdf = with_tags(urdf, wheel, tags)
    # 1.294 is 1.18 on Debian 13, where PyBullet is compiled
    assert turn_rate(urdf, 0.4) == pytest.approx(rate, rel=0.1, abs=0.01)


def test_two_treads_in_one_place_share_the_load():
    urdf = robot(SKID, rows=(0.1, -0.1))
    for wheel in ('left_0', 'right_0', 'left_1', 'right_1'):
        urdf = with_tags(urdf, wheel, '<mu1>1</mu1><mu2>1</mu2><fdir1>0 0 1</fdir1>')
    simulator = assembled(urdf)
    simulator.robots[0].command(0.0, 0.5)
    simulator.advance(500)
    robot_id, client = simulator.robots[0].body.body_id, simulator.world.physics_client_id
    names = {index: name for name, index in link_indices(robot_id, client).items()}
    loads = {True: 0.0, False: 0.0}
    for _ in range(200):
        simulator.advance(1)
        for contact in pybullet.getContactPoints(bodyA=robot_id, physicsClientId=client):
            loads[names[contact[3]].endswith(ACROSS)] += contact[9]
    assert loads[True] == pytest.approx(loads[False], rel=0.05) and loads[True] > 0


def test_second_contacts_of_wheels_do_not_meet_the_chassis():
    urdf = robot(DRIVE + '<gazebo><self_collide>1</self_collide></gazebo>', separation=0.2)
    for wheel in ('left_0', 'right_0'):
        urdf = with_tags(urdf, wheel, '<mu1>0.1</mu1><mu2>0.1</mu2><fdir1>0 0 1</fdir1>')
    simulator = assembled(urdf)
    simulator.robots[0].command(2.0, 0.0)
    simulator.advance(300)
    contacts = pybullet.getContactPoints(physicsClientId=simulator.world.physics_client_id)
    links = [contact[3:5] for contact in contacts if contact[1] == contact[2]]
    assert (len(contacts), links) == (10, [])      # four of each wheel, and two casters


def test_what_touched_is_forgotten_on_a_reset():
    simulator = sdf.simulated(box(mu(0.5, 0.5), name='low', size=(1, 1, 0.1))
                              + box(mu(0.4, 0.4), '0 0 0.15'), sdf.BUILT_IN)
    client = {'physicsClientId': simulator.world.physics_client_id}
    body = simulator.world.scenery[1].body_id

    def coefficient():
        return pybullet.getDynamicsInfo(body, -1, **client)[1]

    simulator.advance(50)
    assert coefficient() == pytest.approx(0.4 / 0.5)
    simulator.reset_world()
    assert coefficient() == pytest.approx(0.4)
