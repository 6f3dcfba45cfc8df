"""Programs on a cluster: a scheduler and two workers, each in its own network."""
import os
import signal
import subprocess
import sys

import av
import numpy as np
import pytest

from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import wait_for

SCHEDULER, WORKERS = '10.213.7.1', ('10.213.7.2', '10.213.7.3')
ADDRESS = 'tcp://{}:8786'.format(SCHEDULER)
SWEEP = '''
runs: 4
time_limit: 0.6
success: {{distance: 1.2}}
parameters:
  goal: blue_post*
  world: color_posts
  colors: {}/config/follow.yaml
  camera_width: 160
  camera_height: 120
  x_pos: {{from: -1.0, to: 0.0}}
'''


def ip(*words):
    subprocess.run(['ip', *words], check=True, stderr=subprocess.DEVNULL)


@pytest.fixture(scope='module')
def networks():
    """Three networks of this test alone, connected by a bridge; their names by address."""
    names = {address: 'ir{}{}'.format(os.getpid(), number)
             for number, address in enumerate((SCHEDULER, *WORKERS))}
    made = []
    try:
        for name in names.values():
            ip('netns', 'add', name)
            made.append(name)
        center = names[SCHEDULER]
        ip('-n', center, 'link', 'add', 'bridge', 'type', 'bridge')
        ip('-n', center, 'addr', 'add', SCHEDULER + '/24', 'dev', 'bridge')
        for number, address in enumerate(WORKERS):
            ip('-n', center, 'link', 'add', 'to{}'.format(number), 'type', 'veth', 'peer', 'name',
               'eth', 'netns', names[address])
            ip('-n', center, 'link', 'set', 'to{}'.format(number), 'master', 'bridge', 'up')
            ip('-n', names[address], 'addr', 'add', address + '/24', 'dev', 'eth')
            ip('-n', names[address], 'link', 'set', 'eth', 'up')
        ip('-n', center, 'link', 'set', 'bridge', 'up')
        for name in names.values():
            ip('-n', name, 'link', 'set', 'lo', 'up')
        yield names
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip('network namespaces cannot be made here: {}'.format(error))
    finally:
        for name in made:
            ip('netns', 'del', name)


@pytest.fixture(scope='module')
def cluster(networks, tmp_path_factory):
    """The processes of the two workers, which a scheduler knows; --nanny starts them again."""
    started, folder = [], tmp_path_factory.mktemp('cluster')

    def start(address, *words):
        log = open(str(folder / 'log{}'.format(len(started))), 'w')
        started.append(subprocess.Popen(
            ['ip', 'netns', 'exec', networks[address], sys.executable, '-m', *words],
            stdout=log, stderr=log, cwd=str(folder), start_new_session=True))
        return started[-1]
    start(SCHEDULER, 'distributed.cli.dask_scheduler', '--host', SCHEDULER, '--no-dashboard')
    yield [start(address, 'distributed.cli.dask_worker', ADDRESS, '--host', address, '--nthreads',
                 '1', '--no-dashboard', '--local-directory', str(folder / 'space'))
           for address in WORKERS]
    for process in started:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture
def run(networks, tmp_path):
    """A function that starts a program in the network of the scheduler."""
    (tmp_path / 's.yaml').write_text(SWEEP.format(ROOT))

    def run(program, *words):
        return subprocess.Popen(
            ['ip', 'netns', 'exec', networks[SCHEDULER], sys.executable,
             os.path.join(ROOT, 'scripts', program), *words], cwd=str(tmp_path),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
            env=dict(os.environ, PWD=str(tmp_path)))
    return run


def ended(process):
    output = process.communicate()[0]
    assert process.returncode == 0, output


@pytest.fixture
def film(tmp_path):
    """A film of 1000 frames, two parts: a card, and only the wall in the second half."""
    with av.open(str(tmp_path / 's.avi'), 'w') as film:
        stream = film.add_stream('mjpeg', 10)
        stream.width, stream.height, stream.pix_fmt = 96, 64, 'yuvj420p'
        for number in range(1000):
            image = np.full((64, 96, 3), 120 + number % 7, np.uint8)
            if number < 500:
                image[10:30, 10:30] = 30, 20, 200
            film.mux(stream.encode(av.VideoFrame.from_ndarray(image, 'bgr24')))
        film.mux(stream.encode(None))
    (tmp_path / 'samples.yaml').write_text(
        'samples:\n- {color: red, rectangle: [10, 10, 20, 20]}\n'
        '- {color: red, not_in_view: [50, 100]}\n')


@pytest.mark.parametrize('program, options, results', [
    ('evaluate.py', ('--colors', os.path.join(ROOT, 'config', 'colors.yaml')),
     ('s.evaluated.csv', 's.evaluated.png')),
    ('fit_colors.py', ('--samples', 'samples.yaml'),
     ('fit_colors.yaml', 'fit_colors.md', 'fit_colors.png', 'fit_colors.csv'))])
def test_recordings_are_copied_to_workers(cluster, run, tmp_path, film, program, options,
                                          results):
    ended(run(program, 's.avi', *options, '--jobs', '1'))
    expected = [(tmp_path / name).read_bytes() for name in results]
    ended(run(program, 's.avi', *options, '--scheduler', ADDRESS, '--copy'))
    assert [(tmp_path / name).read_bytes() for name in results] == expected


def result(tmp_path):
    return [(tmp_path / name).read_bytes() for name in ('s.sweep.csv', 's.sweep.png')]


def count_done(tmp_path):
    return sum(name.endswith('.piece') for _, _, names in os.walk(str(tmp_path / 's.sweep.work'))
               for name in names)


def test_a_cluster_gives_the_bytes_of_one_process_also_after_kills(cluster, run, tmp_path):
    sweep = 'sweep.py', 's.yaml', '--films', '0'
    ended(run(*sweep, '--jobs', '1'))
    expected = result(tmp_path)
    interrupted = run(*sweep, '--scheduler', ADDRESS)
    wait_for(lambda: count_done(tmp_path) or interrupted.poll() is not None, 'a result')
    interrupted.send_signal(signal.SIGINT)
    interrupted.communicate()
    before = count_done(tmp_path)
    resumed = run(*sweep, '--scheduler', ADDRESS, '--copy', '--resume')
    wait_for(lambda: count_done(tmp_path) > before or resumed.poll() is not None, 'a result')
    os.killpg(cluster[0].pid, signal.SIGKILL)
    ended(resumed)
    assert result(tmp_path) == expected
