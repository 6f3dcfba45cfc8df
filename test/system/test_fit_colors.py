"""fit_colors.py as a user runs it, on a street film."""
import os
import re

from img_recog_helpers.pages import ROOT

VIDEO = os.path.join(ROOT, 'test', 'data', 'bikes.mp4')
SAMPLES = os.path.join(ROOT, 'test', 'samples', 'bikes_{}.yaml')
SHARE = r' ([\d.]+)% \|'


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
