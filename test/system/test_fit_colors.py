"""fit_colors.py as a user runs it: on a street film, and with a killed worker and a Ctrl-C."""
import os
import re
import signal

import av
import numpy as np
import psutil
import pytest

from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import wait_for

VIDEO = os.path.join(ROOT, 'test', 'data', 'bikes.mp4')
SAMPLES = os.path.join(ROOT, 'test', 'samples', 'bikes_{}.yaml')
SHARE = r' ([\d.]+)% \|'
FRAMES = 3000       # six parts
CARD = '''
samples:
- {frame: 0, color: red, rectangle: [10, 10, 20, 20]}
- {color: red, not_in_view: [60, 120]}
'''


def test_fitted_bounds_are_better_than_the_articles_on_frames_that_were_not_used(ros, tmp_path):
    process = ros.start_node('fit_colors.py', VIDEO, '--samples', SAMPLES.format('samples'),
                             '--check', SAMPLES.format('check'), '--jobs', '1', cwd=str(tmp_path))
    assert process.wait() == 0, process.output
    report = (tmp_path / 'fit_colors.md').read_text()
    for color, least in (('red', 0.8), ('blue', 0.9)):
        f1, recalls = [], []
        for bounds in ('fitted', 'before'):
            precision, recall, _, frames = (float(share) / 100 for share in re.search(
                r'\| {} \| {} \| check \|'.format(color, bounds) + 4 * SHARE, report).groups())
            f1.append(2 * precision * recall / (precision + recall))
            recalls.append((recall, frames))
        assert f1[0] > least and f1[0] > f1[1] + 0.02
        assert recalls[0] > recalls[1] and recalls[0][1] == 1.0


@pytest.fixture
def fit(ros, tmp_path):
    """A function that starts fit_colors.py on a film of a card, which is away in its second half.
    """
    with av.open(str(tmp_path / 'film.avi'), 'w') as film:
        stream = film.add_stream('mjpeg', 25)
        stream.width, stream.height, stream.pix_fmt = 80, 60, 'yuvj420p'
        for color in ((80, -90, -80), (0, 0, 0)):
            image = 120 + np.random.RandomState(1).randint(-3, 4, (60, 80, 3))
            image[10:30, 10:30] += color
            frame = av.VideoFrame.from_ndarray(image.astype(np.uint8), 'rgb24')
            for _ in range(FRAMES // 2):
                frame.pts = None        # the next one
                film.mux(stream.encode(frame))
        film.mux(stream.encode(None))
    (tmp_path / 's.yaml').write_text(CARD)

    def fit(*options):
        return ros.start_node('fit_colors.py', 'film.avi', '--samples', 's.yaml', *options,
                              cwd=str(tmp_path), env=dict(ros.env, PWD=str(tmp_path)))
    return fit


def wait_for_a_piece(process, tmp_path):
    wait_for(lambda: list(tmp_path.glob('fit_colors.count.work/*/*.piece')),
             lambda: process.output)
    assert process.is_running()


def contents(tmp_path):
    return {path.name: path.read_bytes() for path in tmp_path.glob('fit_colors*.*')}


def test_a_killed_worker_and_an_interruption_make_no_difference(fit, tmp_path):
    process = fit('--jobs', '1')
    assert process.wait() == 0, process.output
    expected = contents(tmp_path)
    assert set(expected) >= {'fit_colors' + end for end in ('.yaml', '.md', '.png', '.csv')}

    process = fit('--jobs', '2')
    wait_for_a_piece(process, tmp_path)
    workers = [child for child in psutil.Process(process.pid).children()
               if 'spawn_main' in ' '.join(child.cmdline())]
    assert len(workers) == 2
    workers[0].kill()
    assert process.wait() == 0, process.output
    assert contents(tmp_path) == expected

    process = fit('--jobs', '2')
    wait_for_a_piece(process, tmp_path)
    process.send_signal(signal.SIGINT)
    assert process.wait() == 128 + signal.SIGINT
    assert re.search('[1-6] of 6 pieces are done and kept in fit_colors.(count|measure).work',
                     process.output)
    process = fit('--jobs', '2', '--resume')
    assert process.wait() == 0, process.output
    assert contents(tmp_path) == expected
    assert not list(tmp_path.rglob('*.piece'))
