"""sweep.py as a user runs it."""
import csv
import os
import re
import textwrap

import pytest

from img_recog_helpers import sdf
from img_recog_helpers.pages import ROOT
from img_recog_helpers.replaying import contents

SWEEP = '''
    runs: 2
    time_limit: 0.6
    success: {{distance: {distance}}}
    parameters:
      goal: blue_post*
      world: color_posts
      camera_width: 160
      camera_height: 120
      camera_rate: 5
      x_pos: {{from: -1.0, to: 0.0}}
      colors: {root}/config/follow.yaml
      light:
        daylight: {{light_exposure: 1}}
        dark: {{light_exposure: 0.1}}
'''
FILES = ['s.sweep.csv', 's.sweep.md', 's.sweep.png', 's.sweep.worst_1.mp4']


@pytest.fixture
def sweep(ros, tmp_path):
    """A function that runs sweep.py on a file; it returns the exit code and the output."""
    def run(*arguments, distance=1.2, **changes):
        text = textwrap.dedent(SWEEP.format(distance=distance, root=ROOT))
        for old, new in changes.items():
            text = re.sub('{}: .*'.format(old), '{}: {}'.format(old, new), text)
        (tmp_path / 's.yaml').write_text(text)
        process = ros.start_node('sweep.py', 's.yaml', *arguments, cwd=str(tmp_path),
                                 env=dict(ros.env, HOME=str(tmp_path), PWD=str(tmp_path),
                                          GAZEBO_MODEL_PATH=str(tmp_path / 'models')))
        code = process.wait()
        return code, '\n'.join(line for line in process.output.splitlines()
                               if not line.startswith('pybullet build time'))
    return run


def test_two_processes_write_the_bytes_of_one(sweep, tmp_path):
    code, output = sweep('--jobs', '1', '--films', '1')
    assert code == 0
    assert re.search(r'^4 runs, \d have succeeded, 0 have no result; wrote s.sweep.csv, ', output,
                     re.M)
    first = contents(tmp_path, '.sweep.')
    assert sorted(set(first) - {'s.sweep.parquet'}) == FILES
    assert sweep('--jobs', '2', '--films', '1')[0] == 0
    assert contents(tmp_path, '.sweep.') == first
    report = (tmp_path / 's.sweep.md').read_text()
    again = re.search(r"`rosrun img_recog sweep.py s.yaml --only '(\S+)'`", report)
    row = next(row for row in csv.DictReader(first['s.sweep.csv'].decode().splitlines())
               if row['key'] == again.group(1))
    code, output = sweep('--only', again.group(1), '--output', 'again')
    assert code == 0 and '{}: {} after {:.3f} s, {:.3f} m from the goal'.format(
        row['key'], row['reason'], float(row['time_s']), float(row['distance_m'])) in output
    film, = (name for name in os.listdir(str(tmp_path)) if name.startswith('again'))
    assert (tmp_path / film).read_bytes() == first['s.sweep.worst_1.mp4']


WORLD = sdf.sdf(
    '<model name="blue_post"><static>1</static><pose>1 0 0.15 0 0 0</pose><link name="l">'
    + sdf.BOX.format('visual', '', '0.1 0.1 0.3') + '</link></model>'
    '<include><uri>model://{}</uri></include>')


def write_wall(tmp_path, name, x):
    """Write a model with the mesh of a wall across the way to the post."""
    folder = tmp_path / 'models' / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'model.sdf').write_text(
        '<sdf version="1.6"><model name="{0}"><static>1</static><link name="l"><collision '
        'name="c"><geometry><mesh><uri>model://{0}/wall.obj</uri></mesh></geometry></collision>'
        '</link></model></sdf>'.format(name))
    (folder / 'wall.obj').write_text('v {0} -2 0\nv {0} 2 0\nv {0} 0 2\nf 1 2 3\n'.format(x))


def test_resume_repeats_what_has_read_other_files_and_nothing_else(sweep, tmp_path):
    for world, wall in (('w', 'wall'), ('other', 'fence')):
        (tmp_path / (world + '.world')).write_text(WORLD.replace('{}', wall))
        write_wall(tmp_path, wall, 3)
    changes = {'world': '[w.world, other.world]', 'x_pos': '0', 'runs': '1', 'distance': 0.05}
    # the report cannot be written, so all results are kept
    (tmp_path / 's.sweep.md').mkdir()
    arguments = '--films', '0', '--jobs', '1'
    assert sweep(*arguments, **changes)[0] == 1
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob('s.sweep.work/*/*')}
    assert len(kept) == 4
    write_wall(tmp_path, 'wall', 0.02)
    assert sweep(*arguments, '--resume', **changes)[0] == 1
    again = {path: path.stat().st_mtime_ns for path in tmp_path.glob('s.sweep.work/*/*')}
    assert kept.items() <= again.items() and len(again) == 6
    (tmp_path / 's.sweep.md').rmdir()
    code, output = sweep(*arguments, '--resume', **changes)
    assert code == 0, output
    with open(str(tmp_path / 's.sweep.csv')) as file:
        touched = {row['key']: row['touched'] for row in csv.DictReader(file)}
    assert touched == {'world={},light={}#1'.format(world, light): 'wall' * (world == 'w')
                       for world in ('w', 'other') for light in ('daylight', 'dark')}


def test_a_run_without_a_result_is_named_and_the_exit_code_says_so(sweep, tmp_path):
    code, output = sweep('--films', '0', '--jobs', '1', goal='nothing')
    assert code == 1 and '4 have no result' in output
    report = (tmp_path / 's.sweep.md').read_text()
    assert '- light=dark#2: the world has no model nothing; it has field, field::south' in report


def test_what_is_refused_is_one_line(sweep, tmp_path):
    code, output = sweep('--jobs', '1', world='mars')
    assert code == 1 and re.search('^sweep.py: error: s.yaml: world: no file ', output)
    assert '\n' not in output and os.listdir(str(tmp_path)) == ['s.yaml']
