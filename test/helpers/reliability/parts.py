"""The parts of `./run test --long`: how much each does at full length, and its figures."""
import functools
import itertools
import pathlib
import tempfile
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from img_recog_helpers import lockstep
from img_recog_helpers.processes import Process
from img_recog_helpers.reliability import (endings, figures, files, images, soak, surroundings,
                                           twists)
from img_recog_helpers.reliability.nodes import Nodes

# at full length
TWISTS, WIRE_TWISTS = 1000000, 60000
IMAGES, WIRE_IMAGES = 100000, 10000
STOPS, KILLS = 500, 300
SOAK_S = 1800.0
LOCKSTEP_RUNS, LOCKSTEP_IMAGES = 100, 100
CLOCK_JUMPS, FULL_DISK_S = 60, 60.0
FILES = 3000

# how results are printed that are not counts
_FORMATS = {'max_s': 'longest {:.2f} s', 'rss_growth_mb': 'memory {:+d} MB'}

Row = Tuple[str, str, str]      # what was done, the result, its limit


class Options(NamedTuple):
    """scale: share of the full length; factor: of all time limits, for a busy machine;
    side_by_side: how many simulations in lockstep run at the same time.
    """

    seed: int
    scale: float = 1.0
    factor: float = 1.0
    side_by_side: int = 8

    def count(self, full: int) -> int:
        return max(1, round(full * self.scale))


def _words(result: Dict) -> str:
    return ', '.join(_FORMATS.get(name, '{} ' + name).format(value)
                     for name, value in result.items())


def _hostile(module: ModuleType, options: Options, counts: Sequence[int], names: Sequence[str],
             limits: Sequence[str]) -> List[Row]:
    """Run both functions of `twists` or `images`.

    counts: of messages in process and to nodes; names: of the messages and of the nodes; limits:
    the last columns.
    """
    (count, wire_count), (name, node) = map(options.count, counts), names
    rows = [('{} {} in process'.format(count, name),
             _words(module.in_process(count, options.seed)), limits[0])]
    with Nodes() as nodes:
        result = module.over_the_wire(wire_count, options.seed, nodes)
    return rows + [('{} {} to {}'.format(wire_count, name, node), _words(result), limits[1])]


def run_twists(options: Options) -> List[Row]:
    """Hostile Twists to the conversion and the simulation, and to a running simulator."""
    return _hostile(twists, options, (TWISTS, WIRE_TWISTS), ('Twists', 'the simulator'),
                    ('no exception, all states finite', 'obeys afterwards, 50 MB'))


def run_images(options: Options) -> List[Row]:
    """Hostile images to the conversions and the recognition, and to running nodes."""
    return _hostile(images, options, (IMAGES, WIRE_IMAGES), ('images', 'color_extract'),
                    ('1 s each', 'right commands afterwards, 60 MB'))


def run_soak(options: Options) -> List[Row]:
    """A demo for half an hour, whose memory, threads and descriptors must not grow."""
    result = soak.run(SOAK_S * options.scale, options.factor)
    rows = []
    for name, late in result.late.items():
        growth = [value for what in soak.MAX_EXTRA for value in (
            getattr(late, what), getattr(late, what) - getattr(result.early[name], what))]
        rows.append((
            '{:g} min of {}'.format(SOAK_S * options.scale / 60, name),
            '{:.1f} MB, {:+.1f} MB; {:g} threads, {:+g}; {:g} descriptors, {:+g}'.format(*growth),
            '+{:g} MB, +{}, +{}'.format(*soak.MAX_EXTRA.values())))
    count, median, most = figures.seconds(result.chain_s)
    return rows + [('{} checks of the chain meanwhile'.format(count),
                    'median {} s, maximum {} s'.format(median, most), '5 s')]


def _endings(options: Options, draw: Callable, full: int, word: str) -> List[Row]:
    result = endings.run(draw, options.count(full), options.seed, options.factor)
    assert not result.failures, '\n'.join(result.failures)
    return [('{} {} of {}'.format(len(times_s), word, program),
             'median {1} s, maximum {2} s'.format(*figures.seconds(times_s)), '{:g} s'.format(
                 endings.DEMO_LIMIT_S if program == 'demo' else endings.NODE_LIMIT_S))
            for program, times_s in sorted(result.times_s.items())]


def run_stops(options: Options) -> List[Row]:
    """SIGINT, SIGTERM and SIGHUP at random moments of start and run."""
    return _endings(options, endings.draw_stop, STOPS, 'stops')


def run_kills(options: Options) -> List[Row]:
    """SIGKILL at random moments of start and run."""
    return _endings(options, endings.draw_kill, KILLS, 'kills')


def run_clock(options: Options) -> List[Row]:
    """/clock that jumps forward, backward and to zero."""
    with Nodes() as nodes:
        times_s = surroundings.clock_jumps(options.count(CLOCK_JUMPS), options.seed, nodes,
                                           options.factor)
    return [('{} jumps of /clock'.format(len(times_s)), 'maximum {:.2f} s'.format(max(times_s)),
             '5 s')]


def run_disk(options: Options) -> List[Row]:
    """A demo whose disk is full."""
    result = surroundings.full_disk(FULL_DISK_S * options.scale, options.factor)
    return [('{:g} s with a full disk'.format(FULL_DISK_S * options.scale),
             '{tracebacks} tracebacks, {lines} lines; the chain took {max_s:.2f} s'.format(
                 **result),
             '3 tracebacks, 40 lines')]


def run_files(options: Options) -> List[Row]:
    """Hostile images, videos, calibrations, robots, worlds and bags to what reads them."""
    return [('{} files: {}'.format(*row[:2]), row[2], '30 s each, 100 MB') for row in files.run(
        options.count(FILES), options.seed)]


def run_lockstep(options: Options) -> List[Row]:
    """Runs in lockstep, some side by side as each other's load, whose paths must be the same."""
    with tempfile.TemporaryDirectory() as folder:
        kinds = _lockstep_kinds(lockstep.compiled(pathlib.Path(folder)))
        return [_lockstep_row(options, kind, run) for kind, run in kinds.items()]


def _lockstep_kinds(program: Optional[pathlib.Path]) -> Dict[str, Callable[[Nodes, str], List]]:
    """Return functions that drive and return the path; program: the node in C++, if there is."""
    def one(start: Callable[[Nodes], Process]) -> Callable[[Nodes, str], List]:
        return lambda nodes, speed: lockstep.path(nodes, speed, start=start,
                                                  images=LOCKSTEP_IMAGES)
    kinds = {
        'a node of random delays': one(functools.partial(
            lockstep.driver, delay='0.005 * numpy.random.random()')),
        'a detector of 0.1 s': one(functools.partial(lockstep.driver, delay='0.1')),
        'two robots': lambda nodes, _: lockstep.paths_of_two(nodes, '0', '0.01',
                                                             images=LOCKSTEP_IMAGES)}
    if program is not None:
        kinds['a node in C++'] = one(lambda nodes: nodes.start(program))
    return kinds


def _lockstep_row(options: Options, kind: str, run: Callable[[Nodes, str], List]) -> Row:
    count = options.count(LOCKSTEP_RUNS)

    def digests(first: int) -> List[str]:
        with Nodes() as nodes:
            return [lockstep.digest(run(nodes, '_real_time_factor:={}'.format(number % 2)))
                    for number in range(first, count, options.side_by_side)]
    with ThreadPoolExecutor(options.side_by_side) as pool:
        paths = set(itertools.chain(*pool.map(digests, range(min(count, options.side_by_side)))))
    assert len(paths) == 1, '{}: {} different paths in {} runs'.format(kind, len(paths), count)
    return ('{}: {} runs of {} images, {} side by side'.format(
        kind, count, LOCKSTEP_IMAGES, options.side_by_side), 'the same path', 'one path')


PARTS: Dict[str, Callable[[Options], List[Row]]] = {
    'soak': run_soak, 'twists': run_twists, 'images': run_images, 'stops': run_stops,
    'kills': run_kills, 'clock': run_clock, 'disk': run_disk, 'files': run_files,
    'lockstep': run_lockstep}
