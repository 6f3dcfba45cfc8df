"""Joints of an SDF: names that are not unique, joints of several axes, closed loops."""
import numpy as np
import pybullet
import pytest

from img_recog_helpers.sdf import INERTIAL, figures, load, model, simulated

LINK = '<link name="{}"><pose>{} 0 0 0</pose>' + INERTIAL + '</link>'
JOINT = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child>{}</joint>'
ABOUT_Y = '<axis><xyz>0 1 0</xyz></axis>'


def places(world):
    """Return where the centers of mass of the links of the first body are, by name."""
    body, client = world.scenery[0].body_id, world.physics_client_id
    found = {pybullet.getBodyInfo(body, physicsClientId=client)[0].decode():
             pybullet.getBasePositionAndOrientation(body, physicsClientId=client)[0]}
    for index in range(pybullet.getNumJoints(body, physicsClientId=client)):
        name = pybullet.getJointInfo(body, index, physicsClientId=client)[12].decode()
        found[name] = pybullet.getLinkState(body, index, computeForwardKinematics=True,
                                            physicsClientId=client)[0]
    return {name: np.array(place) for name, place in found.items()}


def test_links_and_joints_of_the_same_names():
    world = load(LINK.format('a', '0 0 3'), LINK.format('b', '1 0 3'), LINK.format('b', '2 0 3'),
                 LINK.format('m', '3 0 3'), JOINT.format('b', 'revolute', 'a', 'b', ABOUT_Y),
                 JOINT.format('b', 'revolute', 'm::b', 'm', ABOUT_Y),
                 findings=['second link b of m'])
    assert [body.name for body in world.scenery] == ['m']        # as in Gazebo
    assert {name: place.round(6).tolist() for name, place in places(world).items()} == {
        'a': [0, 0, 3], 'b': [1, 0, 3], 'm': [3, 0, 3]}
    assert list(world.scenery[0].joints) == ['b', 'b_1']


def test_a_static_model_can_have_any_joints():
    joints = ''.join(JOINT.format('j', kind, *ends, '<axis><xyz>0 0 0</xyz></axis>')
                     for kind, ends in (('screw', 'ab'), ('revolute', 'ba'), ('gearbox', 'ab'),
                                        ('ball', ('world', 'b'))))
    world = load('<static>1</static>', LINK.format('a', '0 0 3'), LINK.format('b', '1 0 3'),
                 joints)
    world.step(100)
    body, = world.scenery
    assert body.fixed and not body.joints
    assert places(world)['b'].tolist() == [1, 0, 3]


@pytest.mark.parametrize('ends', ['abcb', 'babc', 'abbc'])
@pytest.mark.parametrize('to_world', [('world', 'c'), ('c', 'world')])
def test_joints_can_point_in_any_direction(ends, to_world):
    links = ''.join(LINK.format(name, '{} 0 3'.format(x)) for x, name in enumerate('abc'))
    world = load(links, JOINT.format('one', 'revolute', *ends[:2], ABOUT_Y), JOINT.format(
        'two', 'fixed', *ends[2:], ''), JOINT.format('w', 'fixed', *to_world, ''))
    body, = world.scenery
    world.step(100)
    found = places(world)
    assert body.fixed and found['c'] == pytest.approx([2, 0, 3])
    # `a` swings about the joint, at the child of it
    at = {'a': 0, 'b': 1}[ends[1]]
    assert np.linalg.norm(found['a'] - found['b']) == pytest.approx(1, abs=1e-6)
    assert found['b'][2] == pytest.approx(3) and bool(found['a'][2] < 2.99) is (at == 1)


@pytest.mark.parametrize('kind, axes', [
    ('universal', 2), ('revolute2', 2), ('ball', 3)])
def test_a_pendulum_on_a_joint_of_several_axes_swings_in_both_directions(kind, axes):
    world = load(LINK.format('a', '0 0 2'), JOINT.format(
        'j', kind, 'world', 'a', '<pose>0 0 1 0 0 0</pose><axis><xyz>1 0 0</xyz></axis><axis2>'
        '<xyz>0 1 0</xyz></axis2>'))
    body, = world.scenery
    assert list(body.joints) == ['j::axis_1', 'j::axis_2', 'j'][-axes:] if axes == 3 else [
        'j::axis_1', 'j']
    for x, y, joint in ((0, 1, 0), (-1, 0, 1)):
        body.reset()
        pybullet.resetJointState(body.body_id, list(body.joints.values())[joint], 0.1,
                                 physicsClientId=world.physics_client_id)
        lowest = [places(world)['a']]
        for _ in range(30):
            world.step(100)
            lowest.append(places(world)['a'])
        span = np.ptp(lowest, axis=0)
        assert span[:2] == pytest.approx([abs(x) * 0.2, abs(y) * 0.2], abs=0.01)


# what Gazebo 11.1 gives after 0.5 s for an arm on a joint at the middle of its end, which falls
ARM = ('<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>'
       '<link name="base"/><link name="arm"><pose>0.5 0 0 0 0 0</pose><inertial><mass>1</mass>'
       '<inertia><ixx>0.000416667</ixx><iyy>0.0835417</iyy><izz>0.0835417</izz></inertia>'
       '</inertial></link><joint name="j" type="{}"><pose>-0.5 0 0 0 0 0</pose>'
       '<parent>base</parent><child>arm</child>{}</joint>')
AXES_OF = ('<axis><xyz>{}</xyz><limit><lower>-0.4</lower><upper>0.3</upper></limit></axis><axis2>'
           '<xyz>{}</xyz><limit><lower>-0.4</lower><upper>0.3</upper></limit></axis2>')
ALONE = '<axis><xyz>{}</xyz></axis>'


@pytest.mark.parametrize('kind, axes, positions', [
    ('revolute', ALONE.format('0 2 0'), [1.6615]),
    ('revolute', ALONE.format('0 1 0'), [1.6615]),
    ('prismatic', ALONE.format('3 0 3'), [-0.8680]),
    ('revolute2', AXES_OF.format('0 1 0', '0 0 1'), [-0.4, 0]),
    ('revolute2', AXES_OF.format('0 -1 0', '0 0 1'), [0.3, 0]),
    ('revolute2', AXES_OF.format('0 0 1', '0 1 0'), [0, 1.6615]),
    ('universal', AXES_OF.format('0 1 0', '0 0 1'), [0.3, 0]),
    ('universal', AXES_OF.format('0 0 1', '0 3 0'), [0, 0.3])])
def test_axes_of_any_length_and_direction(kind, axes, positions):
    simulator = simulated(model('m', ARM.format(kind, axes)))
    found = figures(simulator, 0.5).joints()['m::j']
    assert found[::2] == pytest.approx(positions, abs=2e-3)
