"""Draw mutants of the pure folders at random and count how many the unit tests find.

A mutant is a copy of the tree with one small change, like > to >=. It is killed if a unit test
fails or takes too long. Started by ./run mutants.

The operators are those of cosmic-ray. Its runner was tried: it has one test command for all
mutants and starts Python for each (2 s for one file of tests, in place of 0.2 s in a fork), and
drawing, choosing tests by line, two copies at a time and the list of equivalent mutants would be
code of ours all the same, around a database and 12 more packages. mutmut 3 does not change what
is outside of functions or in decorated ones: 16 % of the places here.
"""
import argparse
import concurrent.futures
import os
import queue
import random
import sys
import tempfile
from collections import Counter
from typing import List, Optional

from mutations import Mutant, mutate, places
from records import Equivalents, Record, recorded
from trees import Tree, Worker

_MIN_KILLED = 0.9


def draw(tree: Tree, count: int, seed: int, only: str) -> List[Mutant]:
    """Return mutants of `count` places that are drawn with a seed, one mutant for each place."""
    sources = {file: tree.source(file) for file in tree.pure_files() if only in file}
    found = [place for file, source in sources.items() for place in places(file, source)]
    chosen = random.Random(seed)
    drawn: List[Mutant] = []
    for place in chosen.sample(found, len(found)):
        if len(drawn) == count:
            break
        variant = chosen.randrange(len(place.variants))
        try:
            drawn.append(mutate(place, variant, sources[place.file]))
        except (AttributeError, SyntaxError):   # cosmic-ray: exceptions with a dot, **values
            pass
    print('[mutants] {} of {} places in {} files, --seed {}'.format(
        len(drawn), len(found), len(sources), seed), flush=True)
    return drawn


def run(mutants: List[Mutant], workers: List[Worker], record: Record,
        equivalents: Equivalents) -> Counter:
    """Test mutants with all workers and print each that survives.

    Returns how many were killed, survived, and are equivalent.
    """
    free: 'queue.Queue[Worker]' = queue.Queue()
    for worker in workers:
        free.put(worker)

    def outcome(mutant: Mutant) -> str:
        if mutant in equivalents:
            return 'equivalent'
        worker = free.get()
        try:
            if worker.is_killed(mutant, record.tests(mutant.place), record.limits):
                return 'killed'
        finally:
            free.put(worker)
        print('{}:{}\n    {}\n    {}'.format(
            mutant.place.file, mutant.place.line, mutant.before, mutant.after), flush=True)
        return 'survived'

    counts: Counter = Counter(killed=0, survived=0, equivalent=0)
    with concurrent.futures.ThreadPoolExecutor(len(workers)) as pool:
        for number, each in enumerate(pool.map(outcome, mutants), 1):
            counts[each] += 1
            if number % 50 == 0:
                print('[mutants]', _shown(counts), flush=True)
    return counts


def _shown(counts: Counter) -> str:
    return ', '.join('{} {}'.format(count, name) for name, count in counts.items())


def main(arguments: Optional[List[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog='./run mutants', description=__doc__.split('\n\n')[0])
    parser.add_argument('number', nargs='?', type=int, default=200, help='of mutants (200)')
    parser.add_argument('--seed', type=int, help='repeats a draw (random)')
    parser.add_argument('--only', default='', metavar='TEXT',
                        help='only files whose path contains this text')
    parser.add_argument('--workers', type=int, default=2, help='tested at the same time (2)')
    options = parser.parse_args(arguments)
    root, folder = os.environ['MUTANTS_ROOT'], os.environ['MUTANTS_FOLDER']
    seed = random.SystemRandom().randrange(10000) if options.seed is None else options.seed
    tree = Tree(root)
    mutants = draw(tree, options.number, seed, options.only)
    # not below build/: roslaunch would find each file of the package twice
    with tempfile.TemporaryDirectory(prefix='img_recog_mutants_') as copies:
        workers = [Worker(tree.copy(os.path.join(copies, str(number))),
                          os.environ['MUTANTS_PYTHON']) for number in range(options.workers)]
        try:
            counts = run(mutants, workers, recorded(tree, workers[0], folder),
                         Equivalents(tree.source('test/equivalent_mutants.yaml')))
        finally:
            for worker in workers:
                worker.close()
    print('[mutants] --seed {}: {}'.format(seed, _shown(counts)))
    return 0 if counts['killed'] >= _MIN_KILLED * (counts['killed'] + counts['survived']) else 1


if __name__ == '__main__':
    sys.exit(main())
