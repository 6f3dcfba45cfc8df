"""Where the simulation is seen from, and the copy that the window shows."""
import types

import numpy as np
import pybullet
import pytest

from img_recog.model import SUN
from img_recog.rotations import transform
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.client import connect
from img_recog.simulation.pictures import view, window
from img_recog.simulation.pictures.scene import SceneCopy, poses_of, scene_of
from img_recog.simulation.pictures.view import ABOVE, FIELD_OF_VIEW, follow
from img_recog_helpers import robots, sdf, wheeled


def shelf(x, y, z=1.0, *size):
    """Return a static box; size: in m, 0.2 high and 0.8 in each direction by default."""
    sides = (*size, *(0.8, 0.8, 0.2)[len(size):])
    return sdf.body('shelf{}{}'.format(x, y), '{} {} {}'.format(x, y, z), sdf.box(*sides), True)


LEFT = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))       # a quarter turn


class FakeHelper:
    """A helper whose process is the test: `sent` is what it gets."""

    made = []

    def __init__(self, target, args, niceness):
        self.target, self.args, self.niceness, self.ended = target, args, niceness, False
        self.sent, self.is_sending, self.is_broken = [], False, False
        self.made.append(self)

    def send(self, message):
        self.sent.append(message)

    def end(self):
        self.ended = True
        return 0


@pytest.fixture
def helpers(monkeypatch, clock):
    """The helpers that are made; time stands still but for `clock`."""
    monkeypatch.setattr(FakeHelper, 'made', [])
    monkeypatch.setattr(window, 'HelperProcess', FakeHelper)
    monkeypatch.setattr(window, 'time', types.SimpleNamespace(monotonic=clock))
    return FakeHelper.made


def above(*inside):
    return view.above(sdf.world(*inside))


def camera(pose):
    return '<gui><camera name="user_camera"><pose>{}</pose></camera></gui>'.format(pose)


@pytest.mark.parametrize('pose', [
    '0.8 0 12 0 1.5708 0', '0 0 17 0 1.5708 0', '2.7696 -1.93094 6.71513 0 1.1618 2.27182',
    '1 2 17 0 1.5708 1.0'])
def test_the_view_above_is_that_of_gazebos_user_camera(pose):
    numbers = tuple(map(float, pose.split()))
    found, wanted = above(camera(pose)).pose(), transform(numbers[:3], numbers[3:])
    assert found[:3, 3] == pytest.approx(wanted.translation, abs=0.01)
    assert found[:3, :3] == pytest.approx(wanted.rotation, abs=1e-3)


# that looks upward or is far away, over a shelf, or from below the floor
@pytest.mark.parametrize('pose, models, distance', [
    ('0 0 1 0 -0.5 0', '', 50.0), ('0 0 1e5 0 1.5708 0', '', 50.0),
    ('0 0 5 0 1.5708 0', shelf(1, 2), 6), ('0 0 5 0 1.5 0', shelf(1, 2), 5.0125),
    ('0 0 -1 0 1.5708 0', '', 0.5), ('0 0 5 0 1.5708 1', shelf(1, 2), 5)])
def test_how_far_away_a_user_camera_is(pose, models, distance):
    found = above(camera(pose), models)
    assert found.distance == pytest.approx(distance, rel=1e-3)
    if pose.endswith(' 1'):
        assert found.yaw == pytest.approx(np.degrees(1) - 90, abs=0.01)


def test_without_a_user_camera_it_shows_all_that_stands_in_the_world():
    assert above(sdf.BUILT_IN) == above(shelf(-3, 0), shelf(4, 5)) == ABOVE
    # to 4.7 m from x 0.8, and to 6.3 m from y 0
    for place in ((4.4, 0), (0, 5.7), (0, -5.7)):
        assert above(shelf(*place)) == ABOVE
    for place in ((-3.6, 0), (5.5, 0), (0, 6.3), (0, -6.3)):
        assert above(shelf(*place)) == ABOVE._replace(target=(
            pytest.approx(place[0], abs=0.01), pytest.approx(place[1], abs=0.01), 0.0))
    found = above(shelf(-3, 0), shelf(9, 6))
    assert found == ABOVE._replace(target=(pytest.approx(3.0, abs=0.1), pytest.approx(
        3.0, abs=0.1), 0.0), distance=16.0)
    assert above(shelf(-300, 0), shelf(90, 60)).distance == 300.0
    assert above(shelf(0, 0, 0, 99, 99, 0.01)) == ABOVE
    assert above(shelf(0, 0, 0, 99, 99, 0.1)).distance > 50


@pytest.mark.parametrize('pose, far', [
    ((0.8, 0, 12, 0, 1.5708, 0), 60), ((57.5, -14.75, 58.9, 0, 0.8516, 2.54), 132.41),
    ((0, 0, 100, 0, 1.5708, 0), 105), ((0, 0, 2, 0, 0, 0), 1000), ((0, 0, 2, 0, -1, 0), 1000)])
def test_the_picture_reaches_to_the_floor_in_all_of_it(pose, far):
    slope = np.tan(np.radians(30))
    found = view.near_and_far(transform(pose[:3], pose[3:]).matrix(), (slope, slope * 0.75))
    assert found == pytest.approx((far / 1200, far), rel=1e-4)


@pytest.mark.parametrize('boxes, height', [
    ([(0, 0, 6, 9, 9), (0, 0, 0.8, 9, 9, 0.1), (0, 0, 3, 9, 9)], 2.88),
    ([(0, 0, 1.9, 9, 9)], 1.78),
    ([(0, 0, 2, 2.4, 2.4)], 1.88),      # to 1.2 m on each side
    ([], np.inf), ([(0, 0, 0.8, 9, 9, 0.1)], np.inf),       # a table
    ([(0, 0, 2, 0.5, 9)], np.inf), ([(20, 0, 3, 9, 9)], np.inf),        # a beam; beside it
    *(([(x, y, 2, 9, 9)], np.inf) for x, y in ((-3.6, 0), (3.6, 0), (0, -3.6), (0, 3.6)))])
def test_the_view_ends_under_the_lowest_roof_above_a_robot(boxes, height):
    shelves = (shelf(*box).replace('shelf', 'shelf{}'.format(number))
               for number, box in enumerate(boxes))
    simulator = robots.simulator(sdf.sdf(*shelves))
    assert view.ceiling(simulator.world, [simulator.robots[0].body]) == pytest.approx(
        height, abs=0.01)


def test_the_pose_of_a_viewpoint():
    pose = ABOVE.pose()
    # at (0.8, 0, 12); its x axis leads down, its z axis, upward in the image, along the world's x
    assert pose[:3, 3] == pytest.approx([0.8, 0, 12], abs=0.01)
    assert pose[:3, 0] == pytest.approx([0, 0, -1], abs=1e-3)
    assert pose[:3, 2] == pytest.approx([1, 0, 0], abs=1e-3)
    behind = follow(BodyPose((1.0, 2.0, 0.0), LEFT, ())).pose()
    # it looks along the body's heading, the world's y, and down
    assert behind[:3, 3] == pytest.approx(
        [1, 2 - 1.3 * np.cos(np.radians(68)), 1.3 * np.sin(np.radians(68))], abs=1e-3)
    assert behind[:3, 0] == pytest.approx([0, np.cos(np.radians(68)), -np.sin(np.radians(68))],
                                          abs=1e-3)
    assert behind[:3, 1] == pytest.approx([-1, 0, 0], abs=1e-3)


def test_field_of_view_is_60_degrees_at_4_to_3():
    assert np.degrees(view.horizontal_fov(640, 480)) == pytest.approx(60, abs=0.1)
    assert np.degrees(view.horizontal_fov(480, 480)) == pytest.approx(46.8)


class Requests:
    """The end of a connection in a helper: gives requests, then ends."""

    def __init__(self, *requests):
        self._requests, self.sent = list(requests), []

    def recv(self):
        if not self._requests:
            raise EOFError
        return self._requests.pop(0)

    def poll(self):
        return bool(self._requests) and self._requests[0] is not None

    def send(self, value):
        self.sent.append(value)


@pytest.mark.parametrize('floor', [False, True])
def test_copy_has_the_bodies_at_their_poses_and_maybe_a_floor(floor):
    assembly = robots.assemble('turtlebot3_world', -2.0, -0.5)
    poses, client = poses_of(assembly.simulator), connect()
    assert len(poses) == 2 and poses[1].position[:2] == pytest.approx((-2.0, -0.5))
    copy = SceneCopy(assembly.scene, client, floor)
    assert pybullet.getNumBodies(physicsClientId=client) == 2 + floor
    moved = [poses[0], poses[1]._replace(position=(1.0, 2.0, 0.0))]
    copy.place(moved)
    assert [body.pose().position for body in copy.bodies] == [
        pytest.approx(pose.position, abs=1e-6) for pose in moved]
    for body in range(2):
        shapes = pybullet.getVisualShapeData(body, physicsClientId=client)
        assert len(shapes) > 5
        # one color for each link
        assert len({shape[1] for shape in shapes}) == len({(*shape[7], shape[1])
                                                          for shape in shapes})


def test_joints_of_a_copy_are_those_of_a_skid_steered_robot_with_a_joint_more():
    arm = wheeled.LINK.format(
        name='arm', mass=0.1, i=0.001, origin='', shape='<sphere radius="0.05"/>'
    ) + wheeled.JOINT.format(name='arm', type='continuous', x=0, y=0, z=0.5, roll=0)
    robot = wheeled.robot(arm + wheeled.plugin('gazebo_ros_skid_steer_drive', **{
        '{}{}Joint'.format(side, end): '{}_{}_joint'.format(side, row)
        for side in ('left', 'right') for row, end in enumerate(('Front', 'Rear'))}),
        rows=(0.2, -0.2))
    # the arm before the wheels, too
    for urdf in (robot, robot.replace(arm, '').replace('<link', arm + '<link', 1)):
        sim = wheeled.assembled(urdf).simulator
        sim.robots[0].command(0.5, 1.0)
        sim.advance(500)
        body = sim.robots[0].body
        pybullet.resetJointState(body.body_id, body.joints['arm_joint'], 0.7,
                                 physicsClientId=body.physics_client_id)
        copy = SceneCopy(scene_of(sim), connect(), False)
        copy.place(poses_of(sim))
        assert len(body.joints) == 5
        for joint, (position, *_) in zip(body.joints, body.joint_values()):
            shown = copy.bodies[0]
            assert pybullet.getJointState(shown.body_id, shown.joints[joint],
                                          physicsClientId=shown.physics_client_id)[0] == (
                pytest.approx(position)), joint


def test_copy_of_another_scene_replaces_all_but_the_floor():
    first, second = robots.assemble('turtlebot3_world', -2.0, -0.5), robots.assemble(x=3.0)
    client = connect()
    copy = SceneCopy(first.scene, client, True)
    copy.load(second.scene)
    assert pybullet.getNumBodies(physicsClientId=client) == 2
    copy.place(poses_of(second.simulator))
    assert [body.pose().position[:2] for body in copy.bodies] == [
        pytest.approx((3.0, 0.0), abs=1e-6)]


def test_window_gets_another_scene_before_its_poses(helpers, clock):
    shown = window.Window('scene')
    shown.set_scene('other')
    shown.set_scene('newest')
    for poses in ('poses', 'more'):
        shown.show(poses)
    assert helpers[0].sent == ['newest', 'poses', 'more']


def test_window_never_places_poses_of_an_old_scene(monkeypatch):
    first, second, client = robots.assemble('turtlebot3_world'), robots.assemble(), connect()
    monkeypatch.setattr(window, 'connect', lambda *args: client)
    done = []
    for name in ('place', 'load'):
        monkeypatch.setattr(SceneCopy, name, lambda _, value, name=name: done.append(
            (name, value)))
    window.show_until_closed(
        Requests('old', second.scene, 'new', None, 'old', second.scene), first.scene, ABOVE)
    assert done == [('load', first.scene), ('load', second.scene), ('place', 'new'),
                    ('load', second.scene)]


def test_floor_that_is_seen_is_grey_and_large():
    client = connect()
    SceneCopy(robots.assemble().scene, client, floor=True)
    shapes = pybullet.getVisualShapeData(1, physicsClientId=client)
    assert [shape[7] for shape in shapes] == [pytest.approx((0.72, 0.72, 0.72, 1.0))]
    low, high = shapes[0][5][2] - shapes[0][3][2] / 2, shapes[0][5][2] + shapes[0][3][2] / 2
    assert shapes[0][3] == pytest.approx((40.0, 40.0, 0.01))
    assert (low, high) == pytest.approx((-0.01, 0.0))
    assert shapes[0][5][:2] == pytest.approx((0.0, 0.0))


def test_no_part_of_a_copy_reflects_the_sun(monkeypatch):
    changed = []
    monkeypatch.setattr(pybullet, 'changeVisualShape',
                        lambda *args, **kwargs: changed.append((args, kwargs)))
    assembly, client = robots.assemble('turtlebot3_world', -2.0, -0.5), connect()
    copy = SceneCopy(assembly.scene, client, False)
    assert changed == [((body.body_id, link), {'specularColor': (0, 0, 0),
                                               'physicsClientId': client})
                       for body in copy.bodies for link in body.links]
    assert len(changed) > 10


def test_window_gets_poses_at_30_hz_and_never_blocks(helpers, clock):
    shown = window.Window('scene')
    assert helpers[0].args == ('scene', ABOVE) and shown.due()
    assert shown.show(['pose']) is None and helpers[0].sent == [['pose']]
    clock.advance(0.03)
    assert not shown.due()
    clock.advance(0.004)
    assert shown.due()
    helpers[0].is_sending = True        # it opens slowly, or hangs
    assert shown.show(['lost']) is None and helpers[0].sent == [['pose']]
    helpers[0].is_broken = True
    assert shown.show(['pose']) == 'closed' and helpers[0].ended
    for code in (1, -11):
        helpers[0].end = lambda code=code: code
        assert shown.show(['pose']) == 'it could not be opened or broke'
    closed = window.Window('scene')
    closed.close()
    assert helpers[1].ended


def test_window_shows_the_newest_poses_from_the_camera_above(monkeypatch):
    monkeypatch.setattr(window.os, 'dup2', lambda *_: None)      # stdout of the tests
    assembly, client, seen = robots.assemble(), connect(), {}
    poses = poses_of(assembly.simulator)
    monkeypatch.setattr(window, 'connect', lambda *args: seen.update(connected=args) or client)
    monkeypatch.setattr(pybullet, 'configureDebugVisualizer', lambda *args, **kwargs:
                        seen.setdefault('configured', []).append((args, kwargs)))
    monkeypatch.setattr(pybullet, 'resetDebugVisualizerCamera', lambda **kwargs:
                        seen.update(camera=kwargs))
    placed = []
    monkeypatch.setattr(SceneCopy, 'place', lambda _, poses: placed.append(poses))
    window.show_until_closed(Requests('old', poses, None), assembly.scene, ABOVE)
    assert placed == [poses, None]
    assert seen['connected'][0] == pybullet.GUI
    assert seen['connected'][1].split() == [
        '--background_color_red=0.7', '--background_color_green=0.7',
        '--background_color_blue=0.7', '--width=1024', '--height=768']
    assert seen['configured'] == [
        ((pybullet.COV_ENABLE_GUI, 0), {'physicsClientId': client}),
        ((), {'lightPosition': tuple(-100 * axis for axis in SUN.direction),
              'shadowMapWorldSize': 14, 'shadowMapResolution': 4096,
              'physicsClientId': client}),
        ((pybullet.COV_ENABLE_RENDERING, 0), {'physicsClientId': client})]
    factor = 1.25 * np.tan(np.radians(FIELD_OF_VIEW / 2))
    assert seen['camera'] == {
        'cameraDistance': pytest.approx(12.0 * factor), 'cameraYaw': -90.0,
        'cameraPitch': -89.99, 'cameraTargetPosition': (0.8, 0.0, 0.0),
        'physicsClientId': client}
    assert pybullet.getNumBodies(physicsClientId=client) == 2


def test_window_ends_when_it_is_closed(monkeypatch):
    monkeypatch.setattr(window.os, 'dup2', lambda *_: None)      # stdout of the tests
    scene, client = robots.assemble(sdf.sdf()).scene, connect()
    monkeypatch.setattr(window, 'connect', lambda *args: client)
    monkeypatch.setattr(pybullet, 'isConnected', lambda **kwargs: False)
    window.show_until_closed(None, scene, ABOVE)
    assert pybullet.getNumBodies(physicsClientId=client) == 1      # the robot, and no floor
