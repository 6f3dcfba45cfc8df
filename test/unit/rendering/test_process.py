"""The process that draws: images, depths, its fallback, and how it ends."""
import os
import signal

import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.rendering.camera import Camera
from img_recog.rendering.process import DrawingError, DrawingProcess, Shot
from img_recog.visuals import Light, VisualScene
from img_recog_testing.waiting import DEADLINE_S, stretch, wait_for

pytestmark = pytest.mark.usefixtures('patient_helper')

SCENE = VisualScene((), (False,), Light((0, 0, 1), (0.5, 0.5, 0.5)))
POSES = np.array([[1.0, 2, 3, 0, 0, 0, 1]])
CAMERAS = [Camera(5, 3, 1.0), Camera(8, 6, 1.0)]


class FakeRenderer:
    """Draws its arguments: the process imports it from this module."""

    def load(self, scene, poses):
        self._background = scene.light.background
        return ['no mesh of {}'.format(part) for part in range(1, len(scene.moving))]

    def draw(self, camera, pose, poses):
        image = np.full((camera.height, camera.width, 3), round(poses[0, 0]), np.uint8)
        image[..., 1] = round(pose[0, 3])
        image[..., 2] = round(255 * self._background[2])
        return image

    def depth(self, camera, pose, poses):
        return np.full((camera.height, camera.width), poses[0, 2] + 0.5, np.float32)


class CountingRenderer(FakeRenderer):
    """Draws how many images and depths it has drawn before."""

    def load(self, scene, poses):
        self._images = self._depths = 0
        return super().load(scene, poses)

    def draw(self, camera, pose, poses):
        self._images += 1
        return np.full((camera.height, camera.width, 3), self._images - 1, np.uint8)

    def depth(self, camera, pose, poses):
        self._depths += 1
        return np.full((camera.height, camera.width), self._depths - 1, np.float32)


class Refusal(UserError):
    """There is nothing to draw with."""


def refuse():
    raise Refusal('no OpenGL', 'install it')


def refuse_too():
    raise Refusal('no mesh a.stl', 'give one')


def fail():
    raise RuntimeError('a defect')


@pytest.fixture
def start():
    """A function that starts a process, which is ended after the test."""
    started = []

    def start_process(make=FakeRenderer, make_fallback=refuse_too):
        started.append(DrawingProcess(SCENE, POSES, CAMERAS, make, make_fallback))
        return started[-1]
    yield start_process
    for each in started:
        each.close()
        assert each._helper._process.exitcode is not None


def shot(camera, x, depth=False):
    pose = np.eye(4)
    pose[0, 3] = x
    return Shot(camera, pose, depth)


def ready(process):
    wait_for(lambda: process.wait_ready(0.1), 'the process')
    return process


def answer(process):
    return wait_for(lambda: process.answer(0.1), 'the images')


def test_what_takes_long_at_the_first_image_is_done_when_it_is_ready(start):
    process = ready(start(CountingRenderer))
    process.request([shot(0, 0.0, depth=True)], POSES)
    drawn, = answer(process)
    assert np.all(drawn.image == 1) and np.all(drawn.depth == 1)


def test_images_and_depths_of_several_cameras(start):
    process = ready(start())
    assert not process.busy and process.fallback_reason == ''
    process.request([shot(1, 7), shot(0, 9, depth=True)], POSES)
    assert process.busy
    first, second = answer(process)
    assert not process.busy
    assert first.image.shape == (6, 8, 3) and first.depth is None
    assert first.image[2, 3].tolist() == [1, 7, 128]
    assert second.image[2, 4].tolist() == [1, 9, 128]
    assert second.depth.dtype == np.float32 and second.depth.shape == (3, 5)
    assert np.all(second.depth == 3.5)


def test_an_image_is_valid_until_the_second_request_after_it(start):
    process = ready(start())
    images = []
    for number in range(3):
        process.request([shot(0, number)], POSES)
        images.append(answer(process)[0].image)
        assert images[-1][0, 0, 1] == number
        if number == 1:
            assert images[0][0, 0, 1] == 0
    assert images[0][0, 0, 1] == 2


def test_another_scene_is_drawn_after_it_is_loaded(start):
    process = ready(start())
    assert process.take_missing() == []
    process.load(SCENE._replace(moving=(False, True, True), light=Light((0, 0, 1), (0, 0, 1))),
                 POSES)
    assert process.busy and wait_for(lambda: process.answer(0.1) == [], 'the answer')
    assert not process.busy
    assert process.take_missing() == ['no mesh of 1', 'no mesh of 2']
    assert process.take_missing() == []
    process.request([shot(0, 4)], POSES)
    assert answer(process)[0].image[0, 0].tolist() == [1, 4, 255]


def test_the_fallback_draws_where_the_renderer_cannot(start):
    process = ready(start(refuse, FakeRenderer))
    assert process.fallback_reason == 'no OpenGL; install it'
    process.request([shot(0, 4)], POSES)
    assert answer(process)[0].image[0, 0].tolist() == [1, 4, 128]


def test_an_error_of_the_fallback_is_raised(start):
    process = start(refuse, refuse_too)
    with pytest.raises(DrawingError) as error:
        ready(process)
    assert str(error.value) == 'no mesh a.stl; give one'


@pytest.mark.parametrize('make, code', [(fail, 1), (FakeRenderer, -signal.SIGKILL)])
def test_a_process_that_ends_is_an_error(start, make, code):
    process = start(make)
    if make is FakeRenderer:
        ready(process)
        os.kill(process._helper._process.pid, signal.SIGKILL)
    process.request([shot(0, 1)], POSES)
    with pytest.raises(DrawingError, match='^the process that draws has ended with exit code {}$'
                       .format(code)):
        answer(process)


def test_close_ends_the_process(start):
    process = ready(start())
    process.close()
    assert process._helper._process.exitcode == 0


def test_no_file_is_left_over(start):
    before = set(os.listdir('/dev/shm'))
    process = ready(start())
    os.kill(process._helper._process.pid, signal.SIGKILL)
    process._helper._process.join(DEADLINE_S * stretch())
    # multiprocessing names them after the process; others may have tests at the same time
    own = 'pym-{}-'.format(os.getpid()), 'pym-{}-'.format(process._helper._process.pid)
    assert {name for name in set(os.listdir('/dev/shm')) - before if name.startswith(own)} == set()
