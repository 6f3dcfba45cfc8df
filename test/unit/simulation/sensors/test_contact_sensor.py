"""A bumper that is fixed to a robot against a wall, and what else touches that robot."""
import numpy as np
import pybullet
import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.simulation.configured_model import from_urdf
from img_recog.simulation.sensors import contact_sensor
from img_recog_helpers import robots, sdf

ABOVE = ('<link name="l"><collision name="above"><pose>0 0 2 0 0 0</pose><geometry><sphere>'
         '<radius>0.1</radius></sphere></geometry><surface><friction><ode><mu>0.5</mu></ode>'
         '</friction></surface></collision><collision name="c"><geometry>')
WALL = sdf.sdf(sdf.BUILT_IN, sdf.model('wall', ABOVE, sdf.box(0.2, 4, 1), '</geometry></collision>'
                                       '</link>', pose='1 0 0.5', static=True))
# a bar from x 0.1 to 0.12 of the root, behind it a box that is fixed to the same link
BAR = ('<link name="{0}"><collision><origin xyz="{1} 0 0.06"/><geometry>'
       '<box size="0.02 0.1 0.02"/></geometry></collision></link>'
       '<joint name="{0}_joint" type="fixed">'
       '<parent link="base_footprint"/><child link="{0}"/></joint>')
TAG = ('<gazebo reference="bar"><sensor type="contact" name="s"><update_rate>50</update_rate>'
       '<plugin name="p" filename="libgazebo_ros_bumper.so"><bumperTopicName>b</bumperTopicName>'
       '<frameName>nowhere</frameName></plugin></sensor></gazebo>')
# also where gazebo_msgs cannot be loaded
KINDS = tuple(kind._replace(missing='') for kind in SENSORS)


@pytest.fixture
def simulator():
    urdf = robots.burger('').replace(
        '</robot>', BAR.format('bar', 0.11) + BAR.format('back', -0.2) + TAG + '</robot>')
    robot = from_urdf(urdf, 0.001, lambda uri: None, 'robot', KINDS)
    return robots.build(WALL, [robot.changed(
        spawn=robots.settings_of(x=0.7).spawn, drive=robots.burgers_drive())])


def touches(sim, steps):
    return [each.value for each in sim.advance(steps) if each.sensor == 'contact']


def test_a_bumper_reports_the_wall_and_neither_the_floor_nor_other_parts(simulator):
    robot = simulator.robots[0]
    assert touches(simulator, 500) == [[]] * 25
    robot.command(0.2, 0.0)
    touch, = touches(simulator, 1500)[-1]
    assert (touch.own, touch.other) == (robot.body.name + '::bar', 'wall::l')
    assert touch.positions[:, 0] == pytest.approx(0.9, abs=0.003)
    assert np.all(np.abs(touch.positions[:, 1]) < 0.06)
    assert touch.normals == pytest.approx(np.tile([-1, 0, 0], (len(touch.positions), 1)), abs=0.02)
    assert touch.forces[:, 0].sum() < -0.5
    assert touch.depths.min() >= 0 and touch.depths.max() < 0.003
    robot.command(0.05, 1.5)      # it rubs along the wall to the left
    forces = np.concatenate([touch.forces for found in touches(simulator, 200) for touch in found])
    assert -1.001 < forces[:, 1].sum() / -forces[:, 0].sum() < -0.02   # mu is 1
    robot.command(-0.2, 0.0)
    assert touches(simulator, 1000)[-1] == []
    robot.move_to(0.775, 0.0, 0.0)        # 5 mm from the wall
    assert touches(simulator, 20)[-1] == []


def test_its_shapes_move_with_the_link_that_it_is_fixed_to(simulator):
    robot = simulator.robots[0].body
    index, = robot.surfaces('bar')
    assert robot.surfaces('bar') == {index: 'bar'} and robot.surfaces('back') == {}
    assert robot.mass() == pytest.approx(1.0017, abs=1e-3)


def test_without_its_message_a_bumper_is_reported_with_the_reason():
    kinds = tuple(kind._replace(missing='no x' if kind.name == 'contact' else '')
                  for kind in SENSORS)
    robot = from_urdf(robots.burger('').replace(
        '</robot>', BAR.format('bar', 0.11) + TAG + '</robot>'), 0.001, lambda uri: None,
        'robot', kinds)
    assert 'sensor contact (no x)' in [each.what for each in robot.findings]
    assert 'contact' not in robot.settings.sensors


@pytest.mark.parametrize('names', [('slides', 'floor'), ('floor', 'slides')])
def test_friction_is_against_the_slide_in_any_order_of_the_bodies(names):
    client = {'physicsClientId': pybullet.connect(pybullet.DIRECT)}
    pybullet.setGravity(0, 0, -10, **client)
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(0.5, 0.5, 0.05),
                                          **client)
    bodies = {name: pybullet.createMultiBody(
        name == 'slides', shape, -1, (0, 0, 0.05 if name == 'slides' else -0.05), **client)
        for name in names}
    pybullet.stepSimulation(**client)
    pybullet.resetBaseVelocity(bodies['slides'], (1, 0, 0), **client)
    pybullet.stepSimulation(**client)
    force = sum(contact_sensor.force_of(point) for point in pybullet.getContactPoints(
        bodies['slides'], bodies['floor'], **client))
    assert force[0] < -1 and force[2] > 1
