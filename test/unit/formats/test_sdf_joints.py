"""Joints of an SDF: names that are not unique, joints of several axes, closed loops."""
import numpy as np
import pybullet
import pytest

from img_recog_helpers.sdf import INERTIAL, convert, figures, load, model, simulated

LINK = '<link name="{}"><pose>{} 0 0 0</pose>' + INERTIAL + '</link>'
JOINT = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child>{}</joint>'
ABOUT_Y = '<axis><xyz>0 1 0</xyz></axis>'


def places(world):
    """Return where the centers of mass of the links of the first body are, by name."""
    body, client = world.bodies[0].body_id, world.physics_client_id
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
    assert [body.name for body in world.bodies] == ['m']        # as in Gazebo
    assert {name: place.round(6).tolist() for name, place in places(world).items()} == {
        'a': [0, 0, 3], 'b': [1, 0, 3], 'm': [3, 0, 3]}
    assert list(world.bodies[0].joints) == ['b', 'b_1']


def test_a_static_model_can_have_any_joints():
    joints = ''.join(JOINT.format('j', kind, *ends, '<axis><xyz>0 0 0</xyz></axis>')
                     for kind, ends in (('screw', 'ab'), ('revolute', 'ba'), ('gearbox', 'ab'),
                                        ('ball', ('world', 'b'))))
    world = load('<static>1</static>', LINK.format('a', '0 0 3'), LINK.format('b', '1 0 3'),
                 joints)
    world.step(100)
    body, = world.bodies
    assert body.fixed and not body.joints
    assert places(world)['b'].tolist() == [1, 0, 3]


@pytest.mark.parametrize('ends', ['abcb', 'babc', 'abbc'])
@pytest.mark.parametrize('to_world', [('world', 'c'), ('c', 'world')])
def test_joints_can_point_in_any_direction(ends, to_world):
    links = ''.join(LINK.format(name, '{} 0 3'.format(x)) for x, name in enumerate('abc'))
    world = load(links, JOINT.format('one', 'revolute', *ends[:2], ABOUT_Y), JOINT.format(
        'two', 'fixed', *ends[2:], ''), JOINT.format('w', 'fixed', *to_world, ''))
    body, = world.bodies
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
    body, = world.bodies
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


def joints_of(tree):
    return [(joint.name, joint.parent, joint.child, joint.axis.tolist())
            for joint in tree.model.joints]


TWO = LINK.format('a', '0 0 0') + LINK.format('b', '1 2 3')
AXES = '<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>'


def test_axes_of_a_joint_that_points_to_the_root():
    tied = JOINT.format('w', 'fixed', 'world', 'a', '')
    tree, = convert(TWO, tied, JOINT.format('j', 'universal', 'a', 'b', AXES))
    assert joints_of(tree) == [('j::axis_1', 'a', 'j::axis_1', [1, 0, 0]),
                               ('j', 'j::axis_1', 'b', [0, 1, 0])]
    tree, = convert(TWO, tied, JOINT.format('j', 'universal', 'b', 'a', AXES))
    assert joints_of(tree) == [('j::axis_1', 'a', 'j::axis_1', [0, -1, 0]),
                               ('j', 'j::axis_1', 'b', [-1, 0, 0])]


@pytest.mark.parametrize('kind, why', [
    *((kind, ', which closes a loop of links,') for kind in ('revolute', 'prismatic', 'fixed')),
    ('gearbox', ' of type gearbox, of which the links do not turn about its axes')])
def test_a_joint_of_a_loop_is_left_out_with_a_line_and_holds_nothing(kind, why):
    tree, = convert(TWO, JOINT.format('one', 'revolute', 'a', 'b', ABOUT_Y),
                    JOINT.format('two', kind, 'a', 'b', AXES),
                    findings=('joint two{} of model m'.format(why),))
    assert [(joint.name, joint.kind) for joint in tree.model.joints] == [('one', 'continuous')]


@pytest.mark.parametrize('one, other', ['ab', 'yz', 'zy'])
def test_names_of_links_around_that_of_the_world(one, other):
    links = LINK.format(one, '0 0 0') + LINK.format(other, '1 2 3')
    joint = JOINT.format('j', 'revolute', one, other, ABOUT_Y)
    tree, = convert(links, JOINT.format('w', 'fixed', 'world', one, ''), joint)
    assert joints_of(tree) == [('j', one, other, [0, 1, 0])] and tree.fixed
    tree, = convert(links, joint)
    assert joints_of(tree) == [('j', one, other, [0, 1, 0])] and not tree.fixed
    tree, = convert(links, joint, JOINT.format('w', 'revolute', other, 'world', ABOUT_Y))
    assert [each[:3] for each in joints_of(tree)] == [('w', 'world', other), ('j', other, one)]


def test_joints_of_a_model_in_a_model():
    inner = '<model name="n">' + LINK.format('b', '1 2 3') + '{}</model>'
    tree, = convert(LINK.format('a', '0 0 0'), '<frame name="g" attached_to="f"/>',
                    '<frame name="f" attached_to="a"/>', inner.format(''),
                    JOINT.format('j', 'revolute', 'g', 'n::b', ABOUT_Y),
                    JOINT.format('k', 'revolute', 'a', 'a', ABOUT_Y),
                    findings=('joint k, which joins a link to itself, of m',))
    assert joints_of(tree) == [('j', 'a', 'n::b', [0, 1, 0])]
    trees = convert(inner.format(JOINT.format('j', 'fixed', 'b', 'c', '')), problems=[
        'joint n::j has the link n::c, which does not exist'])
    assert [tree.name for tree in trees] == ['m']
    two = inner.format(LINK.format('c', '0 0 0') + JOINT.format('j', 'revolute', 'b', 'c', ''))
    tree, = convert(two)
    assert joints_of(tree) == [('n::j', 'n::b', 'n::c', [0, 0, 1])]
    convert(TWO, '<joint name="j"><parent>a</parent><child>b</child></joint>',
            problems=['joint j of type , which is held'])


def test_a_loop_between_what_does_not_move_is_nothing():
    tree, = convert(
        '<model name="n"><static>1</static>' + LINK.format('s', '0 0 0') + '</model>', TWO,
        JOINT.format('one', 'revolute', 'n::s', 'a', ABOUT_Y),
        JOINT.format('two', 'revolute', 'world', 'n::s', ABOUT_Y),
        JOINT.format('three', 'revolute', 'a', 'b', ABOUT_Y),
        JOINT.format('four', 'ball', 'world', 'b', ''),
        findings=('joint four, which closes a loop of links, of model m',))
    assert [joint.name for joint in tree.model.joints] == ['one', 'three']
