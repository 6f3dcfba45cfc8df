"""When images of the cameras on robots and of the view are drawn, and where they go."""
import threading
from unittest import mock

import pytest

from img_recog.nodes.gazebo import images
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate, Wait
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.simulation.simulation_settings import Names
from img_recog.simulation.pictures.view import ABOVE, follow, horizontal_fov
from img_recog.simulation.simulation_settings import CameraSettings, ViewSettings
from img_recog_helpers import robots
from img_recog_helpers.waiting import DEADLINE_S

CAMERA = CameraSettings(camera_frame='base_link', camera_width=32, camera_height=24,
                        camera_rate=50.0, camera_optical_frame='lens',
                        camera_image_topic='eye/image', camera_info_topic='eye/info')
BACK = CameraSettings(**{**vars(CAMERA), 'camera_rate': 25.0, 'camera_width': 16,
                         'camera_image_topic': 'back/image', 'camera_info_topic': 'back/info'})
VIEW = '~view/image_raw'
_NOT_YET_S = 0.2        # in which a thread must not have ended


class FakeProcess:
    def __init__(self, scene, poses, cameras, niceness):
        self.scene, self.poses, self.cameras, self.niceness = scene, poses, cameras, niceness
        self.is_ready = self.is_busy = self.is_started = self.has_lost = False
        self.requests = []

    @property
    def is_loading(self):
        return not self.is_ready

    def start(self):
        self.is_started = True

    def set_scene(self, scene, poses):
        self.scene, self.poses = scene, poses

    def set_cameras(self, cameras):
        self.cameras = cameras

    def draw(self, shots, poses, publish):
        self.requests.append((shots, poses, publish))

    def widths(self):
        """Return those of the images of each request, and forget the requests."""
        requests, self.requests = self.requests, []
        return [[shot.camera.width for shot in shots] for shots, *_ in requests]


class FakeStatics(dict):
    set, remove = dict.__setitem__, dict.pop


class Rig:
    """Images of a simulated robot with two cameras, of 32 and 16 pixels in a row."""

    def __init__(self, publishers, redelivery=None, **settings):
        self.gate = TimeGate(Mode.RUNNING, lambda: None, redelivery and 5.0)
        self.simulator, self.statics = robots.assemble(
            x=1.0, cameras=[CAMERA, BACK]), FakeStatics()
        self.robot, self.publishers = self.simulator.robots[0], publishers
        with mock.patch.object(images, 'ImageProcess', self._make_process):
            self.images = Images(
                self.simulator, ViewSettings(view_width=64, view_height=48, **settings),
                self.statics, self.gate, lambda: None, redelivery)
        self.mounted, = self.robot.sensors
        self.images.add_cameras(self.mounted)

    def publish_others(self):
        """Publish the readings of other sensors."""

    def _make_process(self, *args):
        self.process = FakeProcess(*args)
        return self.process

    def step(self, steps=40):
        """Simulate, by default 40 ms: two images of the first camera, one of the second."""
        self.images.enable_cameras()
        self.images.draw(self.simulator.advance(steps), self.publish_others)


@pytest.fixture
def rig(publishers):
    return Rig(publishers)


@pytest.fixture
def watched(rig, publishers):
    """A rig that can draw, whose first camera has a subscriber."""
    publishers['eye/image'].subscribers = 1
    rig.process.is_ready = True
    return rig


def test_in_lockstep_no_other_process_comes_before_the_one_that_draws(publishers):
    assert Rig(publishers).process.niceness > 0
    assert Rig(publishers, Redelivery()).process.niceness == 0


def test_a_camera_is_used_while_it_has_a_subscriber_and_can_be_drawn(rig, publishers):
    rig.step()
    assert not rig.process.is_started and rig.process.requests == []
    publishers['back/info'].subscribers = 1
    rig.step()
    assert rig.process.is_started and rig.process.requests == []
    rig.process.is_ready = True
    rig.step()
    assert rig.process.widths() == [[16]]
    publishers['back/info'].subscribers = 0
    rig.step()
    assert rig.process.requests == []


@pytest.mark.parametrize('settings, lockstep, count', [
    ({}, None, 2), ({'skip_images': True}, None, 0), ({'skip_images': True}, mock.Mock(), 2)])
def test_images_are_skipped_only_if_asked_and_while_others_are_drawn(publishers, settings,
                                                                     lockstep, count):
    rig = Rig(publishers, lockstep, **settings)
    publishers['eye/image'].subscribers = 1
    rig.process.is_ready = rig.process.is_busy = True
    rig.step()
    assert len(rig.process.widths()) == count
    rig.process.is_busy = False
    rig.step()
    assert len(rig.process.widths()) == 2


def test_images_of_one_time_are_one_request(watched, publishers):
    publishers['back/image'].subscribers = 1
    watched.step()
    (_, first_poses, first), (shots, poses, publish) = watched.process.requests
    assert watched.process.widths() == [[32], [32, 16]]
    assert first_poses[0, :3] == pytest.approx([1, 0, 0], abs=1e-3) and poses is not first_poses
    assert shots[0].pose[:3, 3] == pytest.approx([1, 0, 0.01], abs=1e-3)
    publish([('image', None), ('small', None)])
    image, _, header = publishers['eye/image'].sent[0]
    small, _, same = publishers['back/image'].sent[0]
    assert (image, small, header.stamp.to_sec(), same.stamp) == (
        'image', 'small', 0.04, header.stamp)


def test_images_are_drawn_before_their_publication_is_complete(publishers):
    watched, seen = Rig(publishers, Redelivery()), []
    publishers['eye/image'].subscribers, watched.process.is_ready = 1, True

    def state():
        return not watched.gate.awaited(Wait.IMAGES), watched.images.is_complete()
    publishers['eye/image'].publish = lambda *_: seen.append(state())
    assert state() == (True, True)      # nothing was read yet
    watched.step(20)
    assert state() == (False, False)
    watched.process.requests[0][-1]([('image', None)])
    assert seen == [(True, False)] and state() == (True, True)


@pytest.mark.parametrize('redelivery, is_started', [(None, False), (Redelivery(), True)])
def test_world_is_loaded_again_at_once_only_in_lockstep(publishers, redelivery, is_started):
    rig = Rig(publishers, redelivery)
    for has_passed in (False, True):
        rig.process.is_started = False
        rig.images.look()
        assert rig.process.is_started == (is_started or not has_passed)
        rig.process.is_ready = True
        rig.images.look()
        assert rig.gate.may_pass(0)
        rig.process.is_ready = False        # it was killed


def test_an_image_is_drawn_while_others_are_published_and_follows_them(watched, publishers):
    order = []
    publishers['eye/image'].publish = lambda *_: order.append('image')

    def publish_others():
        (_, _, publish), = watched.process.requests
        thread = threading.Thread(target=publish, args=([('image', None)],))
        threads.append(thread)
        thread.start()
        thread.join(_NOT_YET_S)
        order.append('others')
    threads = []
    watched.publish_others = publish_others
    watched.step(20)
    threads[0].join()
    assert order == ['others', 'image']


def test_an_image_that_is_published_late_does_not_wait_for_what_comes_with_the_next(watched):
    watched.step(20)
    (_, _, publish), = watched.process.requests

    def draw(*_):
        # the process takes the next request as soon as it has drawn the first one
        late.start()
        late.join(DEADLINE_S)
        is_published.append(not late.is_alive())
    late, is_published = threading.Thread(
        target=publish, args=([('image', None)],), daemon=True), []
    watched.process.draw = draw
    watched.step(20)
    assert is_published == [True]


def test_of_several_images_none_waits_for_another(watched, publishers):
    order = []
    watched.publish_others = lambda: order.append(len(watched.process.requests))
    watched.process.draw = lambda shots, poses, publish: publish([('image', None)])
    publishers['eye/image'].publish = lambda *_: order.append('image')
    watched.step(60)
    assert order == [0, 'image', 'image', 'image']


def test_cameras_of_a_robot_that_is_removed(rig, publishers):
    def is_camera(reading):
        return rig.images.is_camera(reading)
    publishers['eye/image'].subscribers = 1
    rig.process.is_ready = True
    rig.images.enable_cameras()
    readings = list(filter(is_camera, rig.simulator.advance(40)))
    assert len(readings) == 2 and set(rig.statics) == {'cameras of turtlebot3_burger'}
    assert [each.width for each in rig.process.cameras] == [64, 32, 16]
    rig.images.remove_cameras(rig.mounted)
    assert not any(map(is_camera, readings)) and rig.statics == {}
    assert publishers['eye/image'].is_ended and publishers['back/info'].is_ended
    rig.images.draw(readings, rig.publish_others)
    assert rig.process.requests == []


def test_the_names_of_a_namespace(rig, publishers):
    rig.images.remove_cameras(rig.mounted)
    rig.mounted.spec = rig.mounted.spec._replace(names=Names('r', 'p'))
    rig.images.add_cameras(rig.mounted)
    transform, = rig.statics['cameras of turtlebot3_burger']
    assert transform.header.frame_id == 'p/base_link' and transform.child_frame_id == 'p/lens'
    assert not publishers['r/eye/image'].is_ended


def test_another_scene(rig):
    assert not rig.images.update_scene()
    rig.simulator.world.remove(rig.robot)
    assert rig.images.update_scene() and not rig.images.update_scene()
    assert rig.process.scene.visuals == () and rig.process.poses.shape == (0, 7)


def test_the_view_is_drawn_once_in_a_period_while_it_has_a_subscriber(
        publishers, clock, monkeypatch):
    monkeypatch.setattr(images.time, 'monotonic', clock)
    rig = Rig(publishers, view_rate=10.0)
    rig.images.update_view()
    assert not rig.process.is_started
    publishers[VIEW].subscribers = 1
    rig.images.update_view()
    assert rig.process.is_started and rig.process.requests == []
    rig.process.is_ready = True
    rig.images.update_view()
    clock.advance(0.09)
    rig.images.update_view()
    (shots, _, publish), = rig.process.requests
    assert rig.process.widths() == [[64]]
    assert shots[0].camera[:3] == (64, 48, horizontal_fov(64, 48))
    assert shots[0].pose == pytest.approx(ABOVE.pose())
    publish([('image', None)])
    (image, encoding, header), = publishers[VIEW].sent
    assert (image, encoding, header.frame_id) == ('image', 'rgb8', 'view')
    clock.advance(0.02)
    rig.images.update_view()
    assert rig.process.widths() == [[64]]


def test_the_view_is_drawn_with_the_image_of_a_camera(rig, publishers):
    publishers[VIEW].subscribers = publishers['back/image'].subscribers = 1
    rig.process.is_ready = rig.process.is_busy = True
    rig.images.update_view()
    assert rig.process.requests == []
    rig.step()
    rig.step()
    assert rig.process.widths() == [[16, 64], [16]]


def test_a_view_that_follows(rig, publishers):
    publishers[VIEW].subscribers = 1
    rig.process.is_ready = True
    rig.images.set_view('follow')
    rig.images.update_view()
    (shot,), *_ = rig.process.requests[0]
    assert shot.pose == pytest.approx(follow(rig.robot.body.pose()).pose())
