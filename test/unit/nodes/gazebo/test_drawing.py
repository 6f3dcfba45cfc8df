"""Images are drawn one request at a time, and published in a thread."""
import queue
import re
import threading

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.nodes.gazebo import drawing
from img_recog.nodes.gazebo.drawing import Drawing, Job
from img_recog.rendering.process import Drawn, DrawingError, ProcessEnded, Shot
from img_recog_testing.waiting import DEADLINE_S, wait_for

POSES = np.zeros((1, 7))


class FakeProcess:
    """Answers what the test puts into `answers`: a number of images, or an error."""

    fallback_reason = ''
    made = []
    missing = ()

    def __init__(self, *arguments):
        self.arguments, self.requests, self.is_closed = arguments, [], False
        self.ready, self.answers = queue.Queue(), queue.Queue()
        self.made.append(self)

    def wait_ready(self, timeout_s):
        return self._next(self.ready, timeout_s) is not None

    def request(self, shots, poses):
        self.requests.append((list(shots), poses))

    def load(self, scene, poses):
        self.requests.append((scene, poses))

    def take_missing(self):
        missing, self.missing = self.missing, ()
        return missing

    def answer(self, timeout_s):
        return self._next(self.answers, timeout_s)

    @staticmethod
    def _next(items, timeout_s):
        try:
            item = items.get(timeout=timeout_s)
        except queue.Empty:
            return None
        if isinstance(item, Exception):
            raise item
        return item

    def kill(self):
        self.answers.put(ProcessEnded('killed'))

    def close(self):
        self.is_closed = True


@pytest.fixture
def warnings(monkeypatch):
    """The warnings that are logged."""
    logged = []
    monkeypatch.setattr(drawing.rospy, 'logwarn', lambda text, *values: logged.append(
        text % values))
    return logged


@pytest.fixture
def made(monkeypatch, warnings):
    """A drawing, which is closed at the end."""
    monkeypatch.setattr(FakeProcess, 'made', [])
    monkeypatch.setattr(drawing, 'DrawingProcess', FakeProcess)
    made = Drawing('scene', POSES, ['camera'])
    yield made
    made.close()


def start(made):
    made.start()
    process, = FakeProcess.made
    process.ready.put('')
    wait_for(lambda: made.is_ready, 'the drawing')
    return process


def job(published, name='image'):
    return Job(Shot(0, np.eye(4)), lambda drawn: published.append((name, drawn)))


def image():
    return Drawn(np.zeros((1, 1, 3), np.uint8), None)


def test_nothing_is_started_before_it_is_needed(made):
    assert FakeProcess.made == [] and not made.is_ready
    made.submit([job([])], POSES, 0.0)       # has no effect
    made.start()
    made.start()
    process, = FakeProcess.made
    assert process.arguments[:3] == ('scene', POSES, ['camera']) and not made.is_ready


def test_other_cameras_are_drawn_by_another_process(made):
    first, published = start(made), []
    made.set_cameras(['camera'])        # the same
    assert made.is_ready
    made.submit([job(published)], POSES, 0.0)
    first.answers.put([image()])
    wait_for(lambda: published, 'the image')
    made.set_cameras(['camera', 'other'])
    assert not made.is_ready and not made.is_busy
    wait_for(lambda: first.is_closed, 'the end of the first process')
    made.start()
    second = FakeProcess.made[1]
    second.ready.put('')
    wait_for(lambda: made.is_ready, 'the second process')
    assert second.arguments[2] == ['camera', 'other']
    made.submit([job(published)], POSES, 0.0)
    second.answers.put([image()])
    wait_for(lambda: len(published) == 2, 'its image')


def test_images_are_published_in_their_order(made):
    process, published = start(made), []
    made.submit([job(published, 'a'), job(published, 'b')], POSES, 0.0)
    assert made.is_busy and process.requests[0][1] is POSES
    first, second = image(), image()
    process.answers.put([first, second])
    wait_for(lambda: len(published) == 2, 'the images')
    assert published == [('a', first), ('b', second)] and not made.is_busy


def test_one_more_image_is_drawn_with_the_next_request(made):
    process, published, times = start(made), [], []

    def extra(name):
        def make(time_s):
            times.append((name, time_s))
            return job(published, name)
        return make
    made.add_to_next(extra('old'))
    made.add_to_next(extra('view'))
    made.submit([job(published, 'camera')], POSES, 1.5)
    assert times == [('view', 1.5)] and len(process.requests[0][0]) == 2
    process.answers.put([image(), image()])
    wait_for(lambda: len(published) == 2, 'the images')
    assert [name for name, _ in published] == ['camera', 'view']
    made.submit([job(published)], POSES, 1.6)
    assert len(process.requests[1][0]) == 1 and len(times) == 1


def test_a_request_waits_for_the_one_before(made):
    process, published = start(made), []
    made.submit([job(published)], POSES, 0.0)
    submitted = threading.Event()

    def submit():
        made.submit([job(published)], POSES, 0.0)
        submitted.set()
    threading.Thread(target=submit, daemon=True).start()
    assert not submitted.wait(0.2) and len(process.requests) == 1
    process.answers.put([image()])
    assert submitted.wait(DEADLINE_S) and len(process.requests) == 2


def test_the_next_request_is_drawn_while_an_image_is_published(made):
    process, reached, release = start(made), threading.Event(), threading.Event()

    def publish(_):
        reached.set()
        release.wait(DEADLINE_S)
    made.submit([Job(Shot(0, np.eye(4)), publish)], POSES, 0.0)
    process.answers.put([image()])
    assert reached.wait(DEADLINE_S)
    made.submit([job([])], POSES, 0.0)
    assert len(process.requests) == 2
    release.set()


def test_a_process_that_was_killed_is_replaced(made, warnings):
    process, published = start(made), []
    made.submit([job(published)], POSES, 0.0)
    process.answers.put([image()])
    wait_for(lambda: published, 'the image')
    made.set_scene('other', POSES)      # what the next process starts with
    process.answers.put(ProcessEnded('ended with exit code -9'))
    wait_for(lambda: not made.is_ready, 'the end')
    assert warnings == ['ended with exit code -9; it is started again'] and process.is_closed
    made.submit([job(published)], POSES, 0.0)       # is dropped
    made.start()
    made.start()
    _, second = FakeProcess.made
    assert second.arguments[0] == 'other' and not made.is_ready and not made.is_busy
    second.ready.put('')
    wait_for(lambda: made.is_ready, 'the second process')
    made.submit([job(published)], POSES, 0.0)
    second.answers.put([image()])
    wait_for(lambda: len(published) == 2, 'the second image')


def test_a_process_that_hangs_is_killed(made, warnings, monkeypatch):
    process, published = start(made), []
    made.submit([job(published)], POSES, 0.0)
    process.answers.put([image()])
    wait_for(lambda: published, 'the image')
    monkeypatch.setattr(drawing, '_WARN_AFTER_S', 0.2)
    monkeypatch.setattr(drawing, '_MAX_WAIT_S', 0.6)
    made.submit([job(published)], POSES, 0.0)
    made.submit([job(published)], POSES, 0.0)       # waits, and is dropped
    assert re.match('the simulation waits for images: the process that draws has not answered for '
                    r'\d+ s; it is replaced after 1 s$', warnings[0])
    assert warnings[1:] == ['killed; it is started again']
    assert len(process.requests) == 2


def test_shutdown_does_not_wait_for_an_image(made, monkeypatch):
    process = start(made)
    made.submit([job([])], POSES, 0.0)
    monkeypatch.setattr(drawing.rospy, 'is_shutdown', lambda: True)
    made.submit([job([])], POSES, 0.0)
    made.set_scene('other', POSES)
    assert len(process.requests) == 1


def die(made, number, **when):
    """Start the process of that number, and let it die."""
    made.start()
    process = FakeProcess.made[number]
    if when.get('ready', True):
        process.ready.put('')
        wait_for(lambda: made.is_ready, 'the drawing')
        made.submit([job([])], POSES, 0.0)
        process.answers.put(ProcessEnded('exit code 1'))
    else:
        process.ready.put(ProcessEnded('exit code 1'))
    wait_for(lambda: made._process is None, 'the end')
    assert process.is_closed


def test_three_processes_in_a_row_that_die_before_they_draw_are_the_last(made, warnings):
    die(made, 0)
    die(made, 1, ready=False)
    assert warnings == ['exit code 1; it is started again'] * 2
    die(made, 2)
    made.start()
    assert len(FakeProcess.made) == 3
    assert warnings[2:] == ['no more images: exit code 1; the simulation goes on without them']


def test_a_process_that_draws_ends_the_row(made, warnings):
    published = []
    for number in (0, 1):
        die(made, number)
    made.start()
    process = FakeProcess.made[2]
    process.ready.put('')
    wait_for(lambda: made.is_ready, 'the drawing')
    made.submit([job(published)], POSES, 0.0)
    process.answers.put([image()])
    wait_for(lambda: published, 'the image')
    process.answers.put(ProcessEnded('exit code 1'))
    wait_for(lambda: made._process is None, 'the end')
    die(made, 3)
    assert warnings == ['exit code 1; it is started again'] * 4


def test_a_process_that_hangs_while_it_starts_is_killed(made, warnings, monkeypatch):
    monkeypatch.setattr(drawing, '_MAX_WAIT_S', 0.2)
    monkeypatch.setattr(FakeProcess, 'kill', lambda self: self.ready.put(ProcessEnded('killed')))
    made.start()
    wait_for(lambda: warnings, 'the warning')
    assert warnings == ['killed; it is started again']


def test_a_process_that_cannot_be_started(made, warnings, monkeypatch):
    def refuse(*args):
        raise OSError(24, 'Too many open files')
    monkeypatch.setattr(drawing, 'DrawingProcess', refuse)
    made.start()
    made.start()
    made.submit([job([])], POSES, 0.0)
    assert warnings == ['no more images: cannot start the process that draws: Too many open '
                        'files; the simulation goes on without them']


def test_what_is_missing_is_said_once(made, warnings):
    process, published = start(made), []
    for number in (1, 2):
        process.missing = ['no mesh', 'no texture'][:number]
        made.submit([job(published)], POSES, 0.0)
        process.answers.put([image()])
        wait_for(lambda number=number: len(published) == number, 'the image')
    assert warnings == ['not drawn: no mesh', 'not drawn: no texture']


@pytest.mark.parametrize('while_starting', [True, False])
def test_an_error_ends_the_drawing_with_one_warning(made, warnings, while_starting):
    made.start()
    process, = FakeProcess.made
    if while_starting:
        process.ready.put(DrawingError('no mesh'))
    else:
        process.ready.put('')
        wait_for(lambda: made.is_ready, 'the drawing')
        made.submit([job([])], POSES, 0.0)
        process.answers.put(DrawingError('no mesh'))
    wait_for(lambda: warnings, 'the warning')
    wait_for(lambda: not made.is_ready, 'the end')
    made.submit([job([])], POSES, 0.0)       # does not wait
    made.start()
    assert len(FakeProcess.made) == 1
    assert warnings == ['no more images: no mesh; the simulation goes on without them']


def test_drawing_without_opengl_is_warned_of(made, warnings, monkeypatch):
    monkeypatch.setattr(FakeProcess, 'fallback_reason', 'no EGL')
    start(made)
    assert warnings == ['images are drawn without shadows, and slowly: no EGL']


def reported(made):
    status = DiagnosticStatusWrapper()
    status.summary(DiagnosticStatus.OK, 'fine')
    made.report(status)
    return status.level, status.message, {each.key: each.value for each in status.values}


def test_report(made):
    level, message, values = reported(made)
    assert (level, message) == (DiagnosticStatus.OK, 'fine')
    assert (values['images'], values['drawing, mean (ms)']) == ('0', 'none')
    process, published = start(made), []
    made.submit([job(published), job(published)], POSES, 0.0)
    process.answers.put([image(), image()])
    wait_for(lambda: reported(made)[2]['images'] == '2', 'the images')
    process.answers.put(DrawingError('no mesh'))
    made.submit([job(published)], POSES, 0.0)
    wait_for(lambda: reported(made)[:2] == (
        DiagnosticStatus.WARN, 'no more images: no mesh'), 'the warning')


def test_what_is_not_drawn_is_warned_of(made, warnings, monkeypatch):
    monkeypatch.setattr(FakeProcess, 'missing', ('no a.stl', 'no b.png'))
    process = start(made)
    assert warnings == ['not drawn: no a.stl', 'not drawn: no b.png']
    process.missing = ('no c.stl',)
    made.set_scene('other', POSES)
    assert made.is_busy and process.requests == [('other', POSES)]
    process.answers.put([])
    wait_for(lambda: not made.is_busy, 'the scene')
    assert warnings[2:] == ['not drawn: no c.stl']


def test_another_scene_waits_for_the_images_before(made):
    process, published = start(made), []
    made.submit([job(published)], POSES, 0.0)
    loaded = threading.Event()

    def load():
        made.set_scene('other', POSES)
        loaded.set()
    threading.Thread(target=load, daemon=True).start()
    assert not loaded.wait(0.2) and len(process.requests) == 1
    process.answers.put([image()])
    assert loaded.wait(DEADLINE_S) and process.requests[1][0] == 'other'


def test_another_scene_is_what_the_process_starts_with(made):
    poses = np.ones((2, 7))
    made.set_scene('other', poses)
    assert FakeProcess.made == [] and not made.is_busy
    made.start()
    assert FakeProcess.made[0].arguments[:2] == ('other', poses)


def test_close_ends_a_request_that_waits(monkeypatch, warnings):
    monkeypatch.setattr(FakeProcess, 'made', [])
    monkeypatch.setattr(drawing, 'DrawingProcess', FakeProcess)
    made = Drawing('scene', POSES, ['camera'])
    process = start(made)
    made.submit([job([])], POSES, 0.0)
    thread = threading.Thread(target=made.submit, args=([job([])], POSES, 0.0))
    thread.start()
    made.close()
    thread.join(DEADLINE_S)
    assert process.is_closed and not thread.is_alive() and len(process.requests) == 1
    assert warnings == []
