"""The window, the copy of the simulation that it shows, and its links of one color."""
import types

import numpy as np
import pybullet
import pytest

from img_recog.formats import world_file
from img_recog.model import (BOX, FIXED, SUN, Inertia, Joint, Link, Look, Material, Model, Shape,
                             Solid)
from img_recog.rotations import IDENTITY
from img_recog.simulation.physics.client import connect
from img_recog.simulation.pictures import window
from img_recog.simulation.pictures.view import ABOVE, FIELD_OF_VIEW
from img_recog.simulation.pictures.window import (SceneCopy, poses_of, scene_of,
                                                  split_links_by_color)
from img_recog_helpers import robots, sdf, wheeled
from img_recog_helpers.parsed import lumped
from img_recog_helpers.robots import WORLDS, burger


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


@pytest.fixture(autouse=True)
def stdout(monkeypatch):
    """Leave stdout open for the tests."""
    monkeypatch.setattr(window.os, 'dup2', lambda *_: None)


@pytest.fixture
def helpers(monkeypatch, clock):
    """The helpers that are made; time stands still but for `clock`."""
    monkeypatch.setattr(FakeHelper, 'made', [])
    monkeypatch.setattr(window, 'HelperProcess', FakeHelper)
    monkeypatch.setattr(window, 'time', types.SimpleNamespace(monotonic=clock))
    return FakeHelper.made


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
    simulator = robots.assemble('turtlebot3_world', -2.0, -0.5)
    poses, client = poses_of(simulator), connect()
    assert len(poses) == 2 and poses[1].position[:2] == pytest.approx((-2.0, -0.5))
    copy = SceneCopy(scene_of(simulator), client, floor)
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
        sim = wheeled.assembled(urdf)
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
    copy = SceneCopy(scene_of(first), client, True)
    copy.load(scene_of(second))
    assert pybullet.getNumBodies(physicsClientId=client) == 2
    copy.place(poses_of(second))
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
    first, second = (scene_of(built) for built in (
        robots.assemble('turtlebot3_world'), robots.assemble()))
    client = connect()
    monkeypatch.setattr(window, 'connect', lambda *args: client)
    done = []
    for name in ('place', 'load'):
        monkeypatch.setattr(SceneCopy, name, lambda _, value, name=name: done.append(
            (name, value)))
    window.show_until_closed(
        Requests('old', second, 'new', None, 'old', second), first, ABOVE)
    assert done == [('load', first), ('load', second), ('place', 'new'), ('load', second)]


def test_floor_that_is_seen_is_grey_and_large():
    client = connect()
    SceneCopy(scene_of(robots.assemble()), client, floor=True)
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
    simulator, client = robots.assemble('turtlebot3_world', -2.0, -0.5), connect()
    copy = SceneCopy(scene_of(simulator), client, False)
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


def test_a_window_draws_nothing_until_its_bodies_are_placed(monkeypatch):
    simulator, states = robots.assemble(), []
    monkeypatch.setattr(pybullet, 'configureDebugVisualizer', lambda flag, is_on, **_:
                        states.append((flag, is_on)))
    copy = SceneCopy(scene_of(simulator), connect(), floor=False)
    assert states == [(pybullet.COV_ENABLE_RENDERING, 0)]
    for _ in range(2):
        copy.place(poses_of(simulator))
    assert states == [(pybullet.COV_ENABLE_RENDERING, 0), (pybullet.COV_ENABLE_RENDERING, 1)]


def test_window_shows_the_newest_poses_from_the_camera_above(monkeypatch):
    simulator, client, seen = robots.assemble(), connect(), {}
    poses = poses_of(simulator)
    monkeypatch.setattr(window, 'connect', lambda *args: seen.update(connected=args) or client)
    monkeypatch.setattr(pybullet, 'configureDebugVisualizer', lambda *args, **kwargs:
                        seen.setdefault('configured', []).append((args, kwargs)))
    monkeypatch.setattr(pybullet, 'resetDebugVisualizerCamera', lambda **kwargs:
                        seen.update(camera=kwargs))
    placed = []
    monkeypatch.setattr(SceneCopy, 'place', lambda _, poses: placed.append(poses))
    window.show_until_closed(Requests('old', poses, None), scene_of(simulator), ABOVE)
    assert placed == [poses, None]
    assert seen['connected'][0] == pybullet.GUI
    assert seen['connected'][1].split() == [
        '--background_color_red=0.7', '--background_color_green=0.7',
        '--background_color_blue=0.7', '--width=1024', '--height=768',
        '--nogui']
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
    scene, client = scene_of(robots.assemble(sdf.sdf())), connect()
    monkeypatch.setattr(window, 'connect', lambda *args: client)
    monkeypatch.setattr(pybullet, 'isConnected', lambda **kwargs: False)
    window.show_until_closed(None, scene, ABOVE)
    assert pybullet.getNumBodies(physicsClientId=client) == 1      # the robot, and no floor


@pytest.fixture(params=['burger', 'turtlebot3_world'])
def model(request):
    if request.param == 'burger':
        return lumped(burger())
    return world_file.read('turtlebot3_world', WORLDS).trees[0].model


def test_every_link_has_one_color_and_every_shape_is_kept(model):
    painted = split_links_by_color(model)
    assert all(len({look.material for look in link.looks}) <= 1 for link in painted.links)
    before, after = (sum(len(link.looks) for link in each.links) for each in (model, painted))
    assert before == after > 50


def test_joints_of_the_robot_keep_their_names_and_masses(model):
    painted = split_links_by_color(model)
    assert painted.joints[:len(model.joints)] == model.joints
    for before, after in zip(model.links, painted.links):
        assert (before.name, before.inertia) == (after.name, after.inertia)


def test_added_links_have_no_mass_and_no_inertia_and_are_fixed():
    box, red = Shape(BOX, (1.0, 1.0, 1.0)), Material((1.0, 0.0, 0.0, 1.0))
    inertia = Inertia(1.0, IDENTITY, IDENTITY.rotation)
    looks = Look(box, material=red), Look(box), Look(box, material=red)
    painted = split_links_by_color(Model('r', (Link('a', inertia, (Solid(box),), looks),)))
    assert painted == Model(
        'r', (Link('a', inertia), Link('a_color_0', looks=(looks[0], looks[2])),
              Link('a_color_1', looks=(looks[1],))),
        (Joint('a_color_0_joint', FIXED, 'a', 'a_color_0'),
         Joint('a_color_1_joint', FIXED, 'a', 'a_color_1')))
