"""Copies of the simulation that are drawn: when, from where, and what is sent to them."""
import operator
import os
import signal
import types
from multiprocessing import Pipe

import numpy as np
import pybullet
import pytest

from img_recog.simulation import scene, view, window
from img_recog.simulation.body import Pose
from img_recog.simulation.loading import connect
from img_recog.simulation.rendering import FIELD_OF_VIEW, WINDOW_LIGHT
from img_recog.simulation.scene import SceneCopy, poses_of
from img_recog.simulation.settings import SimulationError, ViewSettings
from img_recog.simulation.view import ABOVE, View, ViewImage, follow
from img_recog_testing import robots

LEFT = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))       # a quarter turn
DEADLINE_S = 60


class FakeHelper:
    """A helper whose process is the test: `theirs` is its end of the connection."""

    made = []

    def __init__(self, target, args):
        self.target, self.args, self.ended = target, args, False
        self.connection, self.theirs = Pipe()
        self.made.append(self)

    def end(self):
        self.ended = True
        return True


@pytest.fixture
def helpers(monkeypatch, clock):
    """The helpers that are made; time stands still but for `clock`."""
    monkeypatch.setattr(FakeHelper, 'made', [])
    for module in (view, window):
        monkeypatch.setattr(module, 'Helper', FakeHelper)
        monkeypatch.setattr(module, 'time', types.SimpleNamespace(monotonic=clock))
    return FakeHelper.made


def test_cameras():
    assert ABOVE == ((0.8, 0.0, 0.0), 12.0, -90.0, -89.99)
    camera = follow(Pose((1.0, 2.0, 3.0), LEFT, ()))
    assert camera.target == (1.0, 2.0, 3.0)
    assert camera[1:] == pytest.approx((1.3, 0.0, -68.0))


def test_one_image_at_a_time_and_not_more_often_than_the_rate(helpers, clock):
    images = View('scene', ViewSettings(view_rate=4.0))
    assert images.due() and helpers == [] and images.next_image(0.0) is None
    images.request(['pose'], 1.5)
    assert len(helpers) == 1 and helpers[0].args[0] == 'scene'
    assert helpers[0].theirs.recv() == (['pose'], 1.5)
    clock.advance(10.0)
    assert not images.due() and images.next_image(0.0) is None
    helpers[0].theirs.send('image')
    assert images.next_image(0.0) == 'image' and images.due()
    images.request(['pose'], 2.0)
    helpers[0].theirs.send('image')
    assert images.next_image(0.0) == 'image' and not images.due()
    clock.advance(0.25)
    assert images.due() and len(helpers) == 1
    images.close()
    assert helpers[0].ended


def test_process_that_ends_is_an_error(helpers):
    images = View('scene', ViewSettings())
    images.close()
    images.request([], 0.0)
    helpers[0].theirs.close()
    with pytest.raises(SimulationError, match='^the process that draws the view has ended$'):
        images.next_image(0.0)
    images.request([], 0.0)
    images.close()
    assert helpers[0].ended


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


@pytest.mark.parametrize('name', ['above', 'follow'])
def test_drawing_uses_the_camera_and_the_size_of_the_settings(monkeypatch, name):
    drawn = []
    monkeypatch.setattr(view, 'render', lambda *args: drawn.append(args[1:]) or 'pixels')
    assembly = robots.assemble(x=0.5)
    poses = poses_of(assembly.simulator)
    connection = Requests((poses, 0.25), (poses, 0.5))
    view._draw(connection, assembly.scene, ViewSettings(view=name, view_width=64, view_height=32))
    assert drawn == [(follow(poses[0]) if name == 'follow' else ABOVE, 64, 32)] * 2
    assert connection.sent == [ViewImage('pixels', 0.25), ViewImage('pixels', 0.5)]


def test_image_comes_from_a_process():
    assembly = robots.assemble()
    images = View(assembly.scene, ViewSettings(view_width=32, view_height=24, view='follow'))
    images.request(poses_of(assembly.simulator), 0.125)
    image = images.next_image(DEADLINE_S)
    assert image.pixels.shape == (24, 32, 3) and image.time_s == 0.125
    assert image.pixels.std() > 0
    images.close()
    assert images._helper._process.exitcode == 0


@pytest.mark.parametrize('floor', [False, True])
def test_copy_has_the_bodies_at_their_poses_and_maybe_a_floor(floor):
    assembly = robots.assemble('turtlebot3_world', -2.0, -0.5)
    poses, client = poses_of(assembly.simulator), connect()
    assert len(poses) == 2 and poses[0].position[:2] == pytest.approx((-2.0, -0.5))
    copy = SceneCopy(assembly.scene, client, floor)
    assert pybullet.getNumBodies(physicsClientId=client) == 2 + floor
    moved = [poses[0]._replace(position=(1.0, 2.0, 0.0)), poses[1]]
    copy.place(moved)
    assert [body.pose().position for body in copy._bodies] == [
        pytest.approx(pose.position, abs=1e-6) for pose in moved]
    for body in range(2):
        shapes = pybullet.getVisualShapeData(body, physicsClientId=client)
        assert len(shapes) > 5
        # one color for each link
        assert len({shape[1] for shape in shapes}) == len({(*shape[7], shape[1])
                                                          for shape in shapes})


def test_floor_that_is_seen_is_grey_and_large():
    client = connect()
    SceneCopy(robots.assemble().scene, client, floor=True)
    shapes = pybullet.getVisualShapeData(1, physicsClientId=client)
    assert [shape[7] for shape in shapes] == [pytest.approx((0.72, 0.72, 0.72, 1.0))]
    low, high = shapes[0][5][2] - shapes[0][3][2] / 2, shapes[0][5][2] + shapes[0][3][2] / 2
    assert shapes[0][3] == pytest.approx((40.0, 40.0, 0.01))
    assert (low, high) == pytest.approx((-0.01, 0.0))


def test_no_part_of_a_copy_reflects_the_sun(monkeypatch):
    changed = []
    monkeypatch.setattr(pybullet, 'changeVisualShape',
                        lambda *args, **kwargs: changed.append((args, kwargs)))
    assembly, client = robots.assemble('turtlebot3_world', -2.0, -0.5), connect()
    copy = SceneCopy(assembly.scene, client, False)
    assert changed == [((body.body_id, link), {'specularColor': (0, 0, 0),
                                               'physicsClientId': client})
                       for body in copy._bodies for link in body.links]
    assert len(changed) > 10


def test_helper_runs_its_target_with_the_connection_and_ends():
    helper = scene.Helper(operator.methodcaller('send', 5), ())
    assert helper.connection.poll(DEADLINE_S) and helper.connection.recv() == 5
    assert helper._process.daemon
    helper._process.join(DEADLINE_S)
    assert helper.end() is True


def test_helper_that_fails_says_so():
    helper = scene.Helper(operator.methodcaller('no_such_method'), ())
    helper._process.join(DEADLINE_S)
    assert helper.end() is False
    killed = scene.Helper(operator.methodcaller('recv'), ())
    killed._process.kill()
    killed._process.join(DEADLINE_S)
    assert killed._process.exitcode < 0 and killed.end() is False


def test_helper_ignores_ctrl_c_and_gives_way_to_the_simulation(monkeypatch):
    done = []
    monkeypatch.setattr(signal, 'signal', lambda *args: done.append(args))
    monkeypatch.setattr(os, 'nice', done.append)
    scene._run(lambda *args: done.append(args), 'connection', (1, 2))
    assert done == [(signal.SIGINT, signal.SIG_IGN), 10, ('connection', 1, 2)]


def test_window_gets_poses_at_30_hz_and_never_blocks(helpers, clock):
    shown = window.Window('scene')
    assert helpers[0].args == ('scene',) and shown.due()
    assert shown.show(['pose']) is None and helpers[0].theirs.recv() == ['pose']
    clock.advance(0.03)
    assert not shown.due()
    clock.advance(0.004)
    assert shown.due()
    for _ in range(100):        # nobody reads: a socket holds less
        assert shown.show([bytes(10000)]) is None
    helpers[0].theirs.close()
    assert shown.show(['pose']) == 'closed' and helpers[0].ended
    helpers[0].end = lambda: False
    assert shown.show(['pose']) == 'it could not be opened or broke'
    closed = window.Window('scene')
    closed.close()
    assert helpers[1].ended


def test_window_shows_the_newest_poses_from_the_camera_above(monkeypatch):
    assembly, client, seen = robots.assemble(), connect(), {}
    poses = poses_of(assembly.simulator)
    monkeypatch.setattr(window, 'connect', lambda *args: seen.update(connected=args) or client)
    monkeypatch.setattr(pybullet, 'configureDebugVisualizer', lambda *args, **kwargs:
                        seen.setdefault('configured', []).append((args, kwargs)))
    monkeypatch.setattr(pybullet, 'resetDebugVisualizerCamera', lambda **kwargs:
                        seen.update(camera=kwargs))
    placed = []
    monkeypatch.setattr(SceneCopy, 'place', lambda _, poses: placed.append(poses))
    window._show(Requests('old', poses, None), assembly.scene)
    assert placed == [poses, None]
    assert seen['connected'][0] == pybullet.GUI
    assert seen['connected'][1].split() == [
        '--background_color_red=0.7', '--background_color_green=0.7',
        '--background_color_blue=0.7', '--width=1024', '--height=768']
    assert seen['configured'] == [
        ((pybullet.COV_ENABLE_GUI, 0), {'physicsClientId': client}),
        ((), dict(WINDOW_LIGHT, physicsClientId=client))]
    factor = 1.25 * np.tan(np.radians(FIELD_OF_VIEW / 2))
    assert seen['camera'] == {
        'cameraDistance': pytest.approx(12.0 * factor), 'cameraYaw': -90.0,
        'cameraPitch': -89.99, 'cameraTargetPosition': (0.8, 0.0, 0.0),
        'physicsClientId': client}
    assert pybullet.getNumBodies(physicsClientId=client) == 2


def test_window_ends_when_it_is_closed(monkeypatch):
    assembly, client = robots.assemble(), connect()
    monkeypatch.setattr(window, 'connect', lambda *args: client)
    monkeypatch.setattr(pybullet, 'isConnected', lambda **kwargs: False)
    window._show(None, assembly.scene)
