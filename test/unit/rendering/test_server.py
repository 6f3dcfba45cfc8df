"""The answers of the process that draws, here in a thread."""
import threading
from multiprocessing import Pipe

import numpy as np
import pytest

from img_recog.model import Surroundings, VisualScene
from img_recog.rendering import server
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Answer, Request, Shot
from img_recog_helpers import fake_renderers
from img_recog_helpers.fake_renderers import REFUSE
from img_recog_helpers.waiting import DEADLINE_S

SCENE = VisualScene((), (False,), surroundings=Surroundings(background=(0.5, 0.5, 0.5)))
POSES = np.array([[1.0, 2, 3, 0, 0, 0, 1]])
SMALL, LARGE = Camera(5, 3, 1.0), Camera(8, 6, 1.0)


def shot(camera, x, depth=False):
    pose = np.eye(4)
    pose[0, 3] = x
    return Shot(camera, pose, depth)


@pytest.fixture
def served():
    """A function that lets a renderer answer requests; it returns its memory and answers."""
    ends = []

    def serve(make, *requests):
        own, other = Pipe()
        memory = np.zeros((server.SLOTS, server.memory_size([SMALL, LARGE])), np.uint8)
        thread = threading.Thread(target=server.serve, args=(other, memory, make), daemon=True)
        ends.append((own, thread))
        thread.start()
        answers = []
        for request in requests or [None]:
            if request is not None:
                own.send(request)
            assert own.poll(DEADLINE_S)
            answers.append(own.recv())
        return memory, answers
    yield serve
    for own, thread in ends:
        own.close()
        thread.join(DEADLINE_S)
        assert not thread.is_alive()


def test_pictures_and_depths_of_several_cameras(served):
    shots = [shot(LARGE, 7), shot(SMALL, 9, depth=True), shot(LARGE, 8)]
    memory, answers = served(fake_renderers.make, Request([], POSES, SCENE),
                             Request(shots[:2], POSES, slot=1), Request(shots[2:], POSES, slot=0))
    assert answers == [Answer([])] * 3
    (first, no_depth), (second, depth) = server.pictures(memory[1], shots[:2])
    assert first.shape == (6, 8, 3) and no_depth is None and np.all(first == (1, 7, 128))
    assert second.shape == (3, 5, 3) and np.all(second == (1, 9, 128))
    assert depth.shape == (3, 5) and depth.dtype == np.float32 and np.all(depth == 1)
    (third, _), = server.pictures(memory[0], shots[2:])
    assert np.all(third == (1, 8, 128))


def test_a_scene_is_drawn_from_its_request_on(served):
    other = SCENE._replace(moving=(False, True, True),
                           surroundings=Surroundings(background=(0, 0, 1)))
    memory, answers = served(fake_renderers.make, Request([], POSES, SCENE),
                             Request([shot(SMALL, 4)], POSES + 1, other))
    assert answers == [Answer([]), Answer(['no mesh of 1', 'no mesh of 2'])]
    assert np.all(server.pictures(memory[0], [shot(SMALL, 4)])[0][0] == (2, 4, 255))


@pytest.mark.parametrize('make, requests, problem', [
    (fake_renderers.refuse, (), 'no mesh a.stl; give one'),
    (fake_renderers.make, (Request([shot(SMALL, REFUSE)], POSES, SCENE),),
     'no memory; buy some')])
def test_an_error_ends_it(served, make, requests, problem):
    assert served(make, *requests)[1] == [Answer(problem=problem)]


def test_the_memory_of_cameras():
    assert server.memory_size([SMALL, LARGE]) == 8 * (15 + 48) and server.memory_size([]) == 0
