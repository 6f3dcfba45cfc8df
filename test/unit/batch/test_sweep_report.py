"""The picture of a sweep."""
import io
from types import SimpleNamespace

import pytest
from matplotlib.axes import Axes

from img_recog.batch import sweep_job
from img_recog.batch.sweep_file import Choice, Range, Run, Success, Sweep, SweepSettings
from img_recog.batch.sweep_job import Ended

CHOICES = Choice('light', {'dim': {}, 'lamp': {}}), Choice('speed', {'1': {}, '2': {}})


def test_the_picture_is_drawn_by_what_the_matplotlib_of_ubuntu_20_04_has(monkeypatch):
    labels = {}
    for name in ('set_xticks', 'set_yticks', 'set_xticklabels', 'set_yticklabels'):
        def with_arguments_of_3_1(axes, values, minor=False, name=name, method=getattr(Axes, name),
                                  **text):
            labels.setdefault(name, list(values))
            assert not text or 'labels' in name
            return method(axes, values, minor=minor, **text)
        monkeypatch.setattr(Axes, name, with_arguments_of_3_1)
    cells = [{'light': light, 'speed': speed} for light in ('dim', 'lamp') for speed in '12']
    runs = [Run('run#{}'.format(number), cell, 1, {'x_pos': number / 7})
            for number, cell in enumerate(cells)]
    ended = [Ended(run, SimpleNamespace(reason=reason))
             for run, reason in zip(runs, ('reached', 'time') * 2)]
    file = io.BytesIO()
    sweep_job.draw(file, 'a', Sweep(SweepSettings(), Success(0.5), {'x_pos': Range(0, 1)},
                                    CHOICES, ('light', 'speed')), ended)
    assert file.getvalue().startswith(b'\x89PNG')
    assert (labels['set_xticklabels'], labels['set_yticklabels']) == (['1', '2'], ['dim', 'lamp'])


def test_a_report_has_no_table_without_rows():
    ended = [Ended(Run('run#1', {}, 1, {}), None, 'there is no world')]
    text = sweep_job.markdown('a.yaml', Sweep(SweepSettings(), Success(0.5), {}, (), ()),
                              ended, [], 'sweep.py a.yaml')
    assert [line for line in text.splitlines() if line] == [
        '# a.yaml', '1 run, of which 0 have succeeded: 0 % (0 to 79).',
        'Without a result: 1 run', '- run#1: there is no world']


@pytest.mark.parametrize('successes, runs, interval', [
    # from R: prop.test(correct = FALSE)
    (0, 10, (0.0, 0.2775)), (5, 10, (0.2366, 0.7634)), (50, 50, (0.9287, 1.0)),
    (81, 263, (0.2553, 0.3662))])
def test_wilson(successes, runs, interval):
    assert sweep_job.wilson(successes, runs) == pytest.approx(interval, abs=1e-4)
