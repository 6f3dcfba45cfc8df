"""The file of a sweep: its runs, their keys and seeds, and what is refused."""
import collections

import pytest
import yaml

from img_recog.batch import sweep_file
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal

POSTS = {'goal': 'blue_post*'}


@pytest.fixture
def read(tmp_path):
    """A function that writes a sweep and reads it."""
    (tmp_path / 'mine.yaml').write_text('colors: [blue]')

    def read(parameters=(), **others):
        path = tmp_path / 'sweep.yaml'
        path.write_text(yaml.safe_dump({'parameters': {**POSTS, **dict(parameters)}, **others},
                                       sort_keys=False))
        return sweep_file.read(str(path))
    return read


LIGHTS = {'dim': {'light_exposure': 0.2}, 'lamp': {'light_temperature': 2700}}


def test_each_combination_has_its_runs(read):
    sweep = read({'x_pos': [1, 2.5], 'light': LIGHTS, 'yaw': {'from': 0, 'to': 1}}, runs=2)
    runs = list(sweep.runs())
    assert sweep.size == len(runs) == 8
    assert [run.key for run in runs[:3]] == ['x_pos=1,light=dim#1', 'x_pos=1,light=dim#2',
                                             'x_pos=1,light=lamp#1']
    assert runs[-1].key == 'x_pos=2.5,light=lamp#2'
    assert runs[-1].labels == {'x_pos': '2.5', 'light': 'lamp'}
    assert {**runs[-1].parameters, 'yaw': 0} == {
        'goal': 'blue_post*', 'x_pos': 2.5, 'yaw': 0, 'light_temperature': 2700.0}
    assert sweep.cells == ('x_pos', 'light')


def test_draws_are_even_and_depend_on_seed_and_key_alone(read):
    def drawn(*light, **others):
        return {run.key: (run.seed, run.parameters['yaw']) for run in read(
            {'yaw': {'from': -1, 'to': 1}, 'light': {name: LIGHTS[name] for name in light}},
            runs=400, **others).runs()}
    few, many, other = drawn('lamp'), drawn('dim', 'lamp'), drawn('lamp', seed=1)
    assert few == {key: many[key] for key in few}
    assert few.keys() == other.keys() and not set(few.values()) & set(other.values())
    counts = collections.Counter(int(2 * (yaw + 1)) for _, yaw in few.values())
    assert sorted(counts) == [0, 1, 2, 3] and min(counts.values()) > 70
    # the same on each machine and in each version
    assert few['light=lamp#1'] == (1763271800, pytest.approx(0.529141, abs=1e-6))


def test_runs_are_known_by_their_values(read, tmp_path):
    for name in ('a/f.yaml', 'b/f.yaml', 'b/f.yml'):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text('colors: [blue]')
    sweep = read({'colors': ['a/f.yaml', 'b/f.yaml', 'b/f.yml', 'mine.yaml'],
                  'x_pos': [1.0000001, 1.0000002, 2], 'light': {
                      1: LIGHTS['dim'], '1': LIGHTS['lamp'], 'a,x_pos=2': LIGHTS['dim']}})
    assert [list(choice.groups) for choice in sweep.choices] == [
        ['a/f', 'b/f.yaml', 'f.yml', 'mine'], ['1.0000001', '1.0000002', '2'],
        ['1', "'1'", "'a,x_pos=2'"]]
    runs = list(sweep.runs())
    assert len(runs) == len({run.key for run in runs}) == sweep.size == 36
    assert len({tuple(run.parameters.values()) for run in runs}) == 24     # dim is there twice


def test_files_begin_in_the_folder_of_the_sweep(read, tmp_path):
    run, = read({'colors': 'mine.yaml', 'world': 'color_posts'}).runs()
    assert run.parameters['colors'] == str(tmp_path / 'mine.yaml')
    assert run.parameters['world'] == 'color_posts' and run.key == 'run#1'


def test_what_is_refused(read, tmp_path):
    expected.check_cases('refused/sweeps.txt', lambda text: refusal(
        read, **yaml.safe_load(text)).replace('{}/'.format(tmp_path), ''))


@pytest.mark.parametrize('text', ['', '[', 'a: 1', 'parameters: 3', 'parameters: {x_pos: 1}'])
def test_what_is_no_sweep(tmp_path, text):
    path = tmp_path / 'a.yaml'
    path.write_text(text)
    assert 'a.yaml' in refusal(sweep_file.read, str(path))
