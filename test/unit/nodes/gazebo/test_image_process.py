"""Images are drawn one request at a time by a process, and published in a thread."""
import multiprocessing
import os
import re
import signal
import threading

import numpy as np
import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from img_recog.model import Surroundings, VisualScene
from img_recog.nodes.gazebo import image_process
from img_recog.nodes.gazebo.image_process import ImageProcess
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Shot
from img_recog_helpers import fake_renderers
from img_recog_helpers.fake_renderers import DIE, HANG, REFUSE
from img_recog_helpers.statuses import report
from img_recog_helpers.waiting import DEADLINE_S, wait_for

pytestmark = pytest.mark.usefixtures('patient_helper')

CAMERA, SMALL = Camera(32, 24, 1.0), Camera(8, 6, 1.0)
POSES = np.array([[1.0, 2, 3, 0, 0, 0, 1]])
SCENE = VisualScene((), (False,), surroundings=Surroundings(background=(0.5, 0.5, 0.5)))
OTHER = SCENE._replace(surroundings=Surroundings(background=(0, 0, 1)), moving=(False, True))
AGAIN = 'the process that draws has ended with exit code {}; it is started again'


class Drawn:
    """What an ImageProcess publishes: the color of each image."""

    def __init__(self, made):
        self.made, self.colors = made, []

    def draw(self, *xs, camera=CAMERA):
        """Draw an image for each x of the camera."""
        self.made.draw([shot(x, camera) for x in xs], POSES, self.publish)

    def publish(self, pictures):
        self.colors += [image[0, 0].tolist() for image, _ in pictures]

    def wait(self, *colors):
        wait_for(lambda: len(self.colors) >= len(colors), 'the images')
        assert self.colors == list(colors)


def shot(x, camera=CAMERA, depth=False):
    pose = np.eye(4)
    pose[0, 3] = x
    return Shot(camera, pose, depth)


@pytest.fixture
def warnings(monkeypatch):
    logged = []
    monkeypatch.setattr(image_process.rospy, 'logwarn', lambda text, *values: logged.append(
        text % values))
    return logged


@pytest.fixture
def make(warnings):
    """A function that makes an ImageProcess and what it publishes; it is closed at the end."""
    made = []

    def make_process(renderer=fake_renderers.make):
        made.append(ImageProcess(SCENE, POSES, [CAMERA] * 2, make=renderer))
        return made[-1], Drawn(made[-1])
    assert multiprocessing.active_children() == []
    yield make_process
    for each in made:
        each.close()
    assert multiprocessing.active_children() == []


def start(made):
    """Start a process and wait until it can draw; return it."""
    made.start()
    child, = multiprocessing.active_children()
    wait_for(lambda: made.is_ready, 'the scene')
    return child


def in_thread(call, *args):
    """Call a function in a thread; return an event that is set when it returns."""
    done = threading.Event()

    def run():
        call(*args)
        done.set()
    threading.Thread(target=run, daemon=True).start()
    return done


def test_nothing_is_started_before_it_is_needed(make, warnings):
    made, drawn = make()
    drawn.draw(7)
    assert multiprocessing.active_children() == [] and not made.is_ready
    made.start()
    drawn.draw(7)       # has no effect yet, and does not wait
    made.start()
    start(made)
    assert not made.is_busy
    drawn.draw(8, 9)
    drawn.wait([1, 8, 128], [1, 9, 128])
    assert not made.is_busy and warnings == []


def test_pictures_are_valid_until_they_are_published(make):
    made, drawn = make()
    start(made)
    pictures, reached, release = [], threading.Event(), threading.Event()

    def publish(found):
        pictures.extend(found)
        reached.set()
        release.wait(DEADLINE_S)
    made.draw([shot(7, depth=True), shot(8, SMALL)], POSES, publish)
    assert reached.wait(DEADLINE_S)
    drawn.draw(9, 9)        # while the first ones are published
    third = in_thread(drawn.draw, 10)
    assert not third.wait(0.3) and made.is_busy and drawn.colors == []
    (first, depth), (second, no_depth) = pictures
    assert first.shape == (24, 32, 3) and np.all(first == (1, 7, 128))
    assert second.shape == (6, 8, 3) and np.all(second == (1, 8, 128)) and no_depth is None
    # one image was drawn before: that for which OpenGL compiles its programs
    assert depth.shape == (24, 32) and np.all(depth == 1)
    release.set()
    assert third.wait(DEADLINE_S)
    drawn.wait([1, 9, 128], [1, 9, 128], [1, 10, 128])


def test_other_cameras_wait_for_the_images_before(make):
    made, drawn = make()
    child = start(made)
    os.kill(child.pid, signal.SIGSTOP)
    drawn.draw(7)
    done = in_thread(made.set_cameras, [CAMERA] * 3)
    assert not done.wait(0.3)
    os.kill(child.pid, signal.SIGCONT)
    assert done.wait(DEADLINE_S)
    wait_for(lambda: drawn.colors[:1] == [[1, 7, 128]], 'the first image')


def test_another_scene_is_drawn_by_the_same_process(make, warnings):
    made, drawn = make()
    child = start(made)
    for scene in (OTHER, SCENE, OTHER):
        made.set_scene(scene, POSES)
    drawn.draw(7)
    drawn.wait([1, 7, 255])
    assert multiprocessing.active_children() == [child]
    assert warnings == ['not drawn: no mesh of 1']      # once


def test_other_scenes_while_the_process_loads_or_draws(make):
    made, drawn = make()
    made.start()
    child, = multiprocessing.active_children()
    for scene in (SCENE, OTHER) * 50:
        made.set_scene(scene, POSES)
    assert start(made) is child         # none of them waits, or needs another process
    os.kill(child.pid, signal.SIGSTOP)
    drawn.draw(7)
    for scene in (OTHER, SCENE) * 50:
        made.set_scene(scene, POSES)    # does not wait
    assert made.is_busy
    os.kill(child.pid, signal.SIGCONT)
    drawn.draw(8)
    drawn.wait([1, 7, 255], [1, 8, 128])


def test_scenes_that_change_all_the_time_do_not_keep_it_from_drawing(make):
    made, drawn = make()
    end = threading.Event()

    def change():
        while not end.is_set():
            made.set_scene(OTHER, POSES)
            made.start()
    changing = threading.Thread(target=change)
    changing.start()
    wait_for(lambda: made.is_ready, 'the scene')
    for x in range(3):
        drawn.draw(x)
    wait_for(lambda: len(drawn.colors) == 3, 'the images')
    end.set()
    changing.join(DEADLINE_S)
    assert [color[1] for color in drawn.colors] == [0, 1, 2]


def test_more_cameras_are_drawn_by_another_process(make):
    made, drawn = make()
    first = start(made)
    made.set_cameras([SMALL])       # needs no more memory
    assert made.is_ready
    made.set_cameras([CAMERA] * 3)
    assert not made.is_ready and not made.is_busy
    first.join(DEADLINE_S)
    assert start(made) is not first
    drawn.draw(7, 8, 9)
    drawn.wait([1, 7, 128], [1, 8, 128], [1, 9, 128])


@pytest.mark.parametrize('is_busy', [False, True])
def test_a_process_that_was_killed_is_replaced(make, warnings, is_busy):
    before = set(os.listdir('/dev/shm'))
    made, drawn = make()
    child = start(made)
    drawn.draw(7)
    drawn.wait([1, 7, 128])
    # what the next one starts with
    made.set_scene(SCENE._replace(surroundings=OTHER.surroundings), POSES)
    wait_for(lambda: not made.is_busy, 'the scene')
    if is_busy:
        os.kill(child.pid, signal.SIGSTOP)
        drawn.draw(8)
    os.kill(child.pid, signal.SIGKILL)
    wait_for(lambda: not made.is_ready, 'the end')
    drawn.draw(9)           # is dropped
    assert not made.is_busy
    start(made)
    drawn.draw(10)
    drawn.wait([1, 7, 128], [1, 10, 255])
    assert warnings == [AGAIN.format(-9)]
    # multiprocessing names them after the process; others may have tests at the same time
    own = 'pym-{}-'.format(os.getpid()), 'pym-{}-'.format(child.pid)
    assert not {name for name in set(os.listdir('/dev/shm')) - before if name.startswith(own)}


def test_three_processes_in_a_row_that_do_not_draw_are_the_last(make, warnings):
    made, drawn = make()
    expected = [AGAIN.format(1)] * 3 + [
        'no more images: the process that draws has ended with exit code 1; the simulation goes '
        'on without them']
    for number in range(4):
        start(made)
        if number == 1:         # a process that draws ends the row
            drawn.draw(7)
            drawn.wait([1, 7, 128])
        drawn.draw(DIE)
        wait_for(lambda: not made.is_ready, 'the end')
        wait_for(lambda: multiprocessing.active_children() == [], 'the end of the process')
        assert warnings == expected[:number + 1]
    made.start()
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize('is_starting', [False, True])
def test_a_process_that_hangs_is_killed(make, warnings, monkeypatch, is_starting):
    made, drawn = make(fake_renderers.hang if is_starting else fake_renderers.make)
    if is_starting:
        monkeypatch.setattr(image_process, '_MAX_WAIT_S', 0.4)
        made.start()
    else:
        start(made)
        monkeypatch.setattr(image_process, '_WARN_AFTER_S', 0.2)
        monkeypatch.setattr(image_process, '_MAX_WAIT_S', 0.6)
        drawn.draw(HANG)
        drawn.draw(7)           # waits, and is dropped
        assert re.match('the simulation waits for images: the process that draws has not answered '
                        r'for \d+ s; it is replaced after 1 s$', warnings.pop(0))
    wait_for(lambda: warnings, 'the warning')
    assert warnings == [AGAIN.format(-9)] and drawn.colors == []


@pytest.mark.parametrize('is_shut_down', [False, True])
def test_topics_that_are_closed_while_it_publishes_are_an_error_until_the_shutdown(
        make, monkeypatch, is_shut_down):
    errors, published = [], threading.Event()
    monkeypatch.setattr(threading, 'excepthook', errors.append)
    monkeypatch.setattr(rospy.core, 'is_shutdown_requested', lambda: is_shut_down)

    def publish(pictures):
        published.set()
        raise rospy.ROSException('topic was closed during publish()')
    made, _ = make()
    start(made)
    made.draw([shot(1)], POSES, publish)
    assert published.wait(DEADLINE_S)
    made.close()
    assert len(errors) == (0 if is_shut_down else 1)


@pytest.mark.parametrize('is_starting, problem', [
    (False, 'no memory; buy some'), (True, 'no mesh a.stl; give one')])
def test_an_error_ends_the_drawing_with_one_warning(make, warnings, is_starting, problem):
    made, drawn = make(fake_renderers.refuse if is_starting else fake_renderers.make)
    if is_starting:
        made.start()
    else:
        start(made)
        drawn.draw(REFUSE)
    wait_for(lambda: warnings, 'the warning')
    drawn.draw(7)               # does not wait
    made.start()
    assert not made.is_ready and drawn.colors == []
    assert warnings == ['no more images: {}; the simulation goes on without them'.format(problem)]
    level, message, _ = report(made)
    assert (level, message) == (DiagnosticStatus.WARN, 'no more images: ' + problem)


def test_a_process_that_cannot_be_started(make, warnings, monkeypatch):
    def refuse(*args, **kwargs):
        raise OSError(24, 'Too many open files')
    monkeypatch.setattr(image_process, 'HelperProcess', refuse)
    made, drawn = make()
    made.start()
    made.start()
    drawn.draw(7)
    assert warnings == ['no more images: cannot start the process that draws: Too many open '
                        'files; the simulation goes on without them']


def test_report(make):
    made, drawn = make()
    start(made)
    level, message, values = report(made)
    assert (level, message) == (DiagnosticStatus.OK, 'fine')
    assert (values['images'], values['drawing, mean (ms)']) == ('0', 'none')
    drawn.draw(7, 8)
    wait_for(lambda: report(made)[2]['images'] == '2', 'the images')


@pytest.mark.parametrize('is_shutdown', [False, True])
def test_what_waits_ends_with_the_node(make, warnings, impatient, monkeypatch, is_shutdown):
    made, drawn = make()
    os.kill(start(made).pid, signal.SIGSTOP)
    drawn.draw(7)
    waiting = in_thread(drawn.draw, 8)
    assert not waiting.wait(0.2)
    if is_shutdown:
        monkeypatch.setattr(image_process.rospy, 'is_shutdown', lambda: True)
    else:
        made.close()
    assert waiting.wait(DEADLINE_S)
    assert drawn.colors == [] and warnings == []
