"""Draw mutants of the pure folders at random and count how many the unit tests find.

A mutant is a copy of the tree with one small change, like > to >=. It is killed if a unit test
fails or takes too long. Started by ./run mutants.
"""
import argparse
import concurrent.futures
import os
import queue
import random
import sys
from typing import List, NamedTuple, Optional

from mutations import Mutant, mutate, places
from records import Equivalents, Record, recorded
from trees import Tree, Worker

_MIN_KILLED = 0.9


class Result(NamedTuple):
    """What became of a mutant. outcome: killed, survived or equivalent."""

    mutant: Mutant
    outcome: str


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
        equivalents: Equivalents) -> List[Result]:
    """Test mutants with all workers; print each that survives."""
    free: 'queue.Queue[Worker]' = queue.Queue()
    for worker in workers:
        free.put(worker)

    def test(mutant: Mutant) -> Result:
        if mutant in equivalents:
            return Result(mutant, 'equivalent')
        worker = free.get()
        try:
            killed = worker.is_killed(mutant, record.tests(mutant.place), record.limits)
        finally:
            free.put(worker)
        if not killed:
            print('{}:{}\n    {}\n    {}'.format(
                mutant.place.file, mutant.place.line, mutant.before, mutant.after), flush=True)
        return Result(mutant, 'killed' if killed else 'survived')

    results: List[Result] = []
    with concurrent.futures.ThreadPoolExecutor(len(workers)) as pool:
        for result in pool.map(test, mutants):
            results.append(result)
            if len(results) % 50 == 0:
                print('[mutants] {}'.format(_counts(results)), flush=True)
    return results


def _counts(results: List[Result]) -> str:
    return ', '.join('{} {}'.format(sum(result.outcome == outcome for result in results), outcome)
                     for outcome in ('killed', 'survived', 'equivalent'))


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
    tree = Tree(root, folder)
    mutants = draw(tree, options.number, seed, options.only)
    workers = [Worker(tree.copy('copy{}'.format(number)), os.environ['MUTANTS_PYTHON'])
               for number in range(options.workers)]
    try:
        record = recorded(tree, workers[0], folder)
        results = run(mutants, workers, record,
                      Equivalents(tree.source('test/equivalent_mutants.yaml')))
    finally:
        for worker in workers:
            worker.close()
    print('[mutants] --seed {}: {}'.format(seed, _counts(results)))
    killed, survived = (sum(result.outcome == outcome for result in results)
                        for outcome in ('killed', 'survived'))
    return 0 if killed >= _MIN_KILLED * (killed + survived) else 1


if __name__ == '__main__':
    sys.exit(main())
