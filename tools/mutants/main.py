"""Draw mutants of the pure folders at random and count how many the unit tests find.

A mutant is a copy of the tree with one small change, like > to >=. It is killed if a unit test
fails or takes too long. Started by ./run mutants.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import queue
import random
import shutil
import subprocess
import sys
from typing import Dict, Iterable, List, NamedTuple, Optional

import yaml

from mutations import Mutant, Place, mutate, places

PURE = ('camera', 'conversions', 'recognition', 'rendering', 'replay', 'simulation',
        'teleoperation')
PURE_FILES = ('errors.py', 'files.py', 'resources.py', 'robot_file.py', 'settings.py')
SOURCES = 'src/img_recog'
# what tests read, beside their own file
SHARED = ('config/', 'src/', 'test/img_recog_testing/', 'test/unit/', 'urdf/')
# in test/unit; all others are run
OTHER_TESTS = ('nodes', 'ros', 'test_walls.py')
_MIN_KILLED = 0.9


class Tree:
    """The files of the working tree, and the copies of it in a folder."""

    def __init__(self, root: str, folder: str):
        self._root = root
        self._folder = folder
        listed = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=root,
                                stdout=subprocess.PIPE, check=True, universal_newlines=True)
        self.files = sorted(name for name in listed.stdout.splitlines()
                            if os.path.isfile(os.path.join(root, name)))

    def source(self, file: str) -> str:
        """Return the text of a file."""
        return self._content(file).decode()

    def pure_files(self) -> List[str]:
        """Return the files that are mutated."""
        parts = ((name, name[len(SOURCES) + 1:].split('/')) for name in self.files
                 if name.startswith(SOURCES + '/') and name.endswith('.py'))
        return [name for name, path in parts
                if path[0] in PURE or (len(path) == 1 and path[0] in PURE_FILES)]

    def test_files(self) -> Dict[str, str]:
        """Return the files with tests that are run, and a digest of all that decides each result.
        """
        tests = [name for name in self.files if name.startswith('test/unit/')
                 and os.path.basename(name).startswith('test_')
                 and name[len('test/unit/'):].split('/')[0] not in OTHER_TESTS]
        shared = hashlib.sha1()
        for name in self.files:
            if name.startswith(SHARED) and name not in tests:
                shared.update(name.encode() + self._content(name))
        return {name: hashlib.sha1(shared.digest() + self._content(name)).hexdigest()
                for name in tests}

    def _content(self, name: str) -> bytes:
        with open(os.path.join(self._root, name), 'rb') as stream:
            return stream.read()

    def copy(self, name: str) -> str:
        """Make a copy with this name and return its path."""
        path = os.path.join(self._folder, name)
        shutil.rmtree(path, ignore_errors=True)
        for file in self.files:
            os.makedirs(os.path.dirname(os.path.join(path, file)), exist_ok=True)
            shutil.copy2(os.path.join(self._root, file), os.path.join(path, file))
        return path


class Worker:
    """A copy of the tree and the process that runs tests in it."""

    def __init__(self, copy: str, python: str):
        self.copy = copy
        here = os.path.dirname(os.path.abspath(__file__))
        paths = [copy + '/src', copy + '/test', os.environ.get('PYTHONPATH', '')]
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(paths), ROS_PACKAGE_PATH=(
            copy + os.pathsep + os.environ.get('ROS_PACKAGE_PATH', '')))
        self._process = subprocess.Popen(
            [python, os.path.join(here, 'worker.py'), copy], env=environment,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True)

    def ask(self, **request) -> int:
        """Send a request to worker.py and return the exit code of the tests."""
        print(json.dumps(request), file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline()
        if not answer:
            sys.exit('[mutants] {} ended, see above'.format(self.copy))
        return json.loads(answer)['code']

    def is_killed(self, mutant: Mutant, tests: List[str], limits: Dict[str, float]) -> bool:
        """Return whether a test fails with a mutant."""
        if not tests:
            return False
        path = os.path.join(self.copy, mutant.place.file)
        with open(path, encoding='utf-8') as stream:
            source = stream.read()
        try:
            with open(path, 'w', encoding='utf-8') as stream:
                stream.write(mutant.source)
            code = self.ask(tests=tests, limits=limits)
        finally:
            with open(path, 'w', encoding='utf-8') as stream:
                stream.write(source)
        return code != 0

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()


class Record:
    """Which tests run which line, and how long each takes."""

    def __init__(self, paths: Iterable[str]):
        self._seconds: Dict[str, float] = {}
        self._lines: Dict[str, Dict[str, List[str]]] = {}
        for path in paths:
            with open(path) as stream:
                record = json.load(stream)
            self._seconds.update(record['seconds'])
            for file, lines in record['lines'].items():
                known = self._lines.setdefault(file, {})
                for line, tests in lines.items():
                    known.setdefault(line, []).extend(tests)
        self.limits = {test: 10 + 5 * seconds for test, seconds in self._seconds.items()}

    def tests(self, place: Place) -> List[str]:
        """Return the tests for a place: groups of tests, and in each the fastest first.

        In a function: those that run it, then the other tests of its file (what is cached is run
        by the first test only). Other lines are run once, by the import: the tests of the file,
        those that run anything of it, all others of its folder and of test/unit itself.
        """
        lines = self._lines.get(place.file, {})
        folder, name = os.path.split(os.path.relpath(place.file, SOURCES))
        mirror = 'test/unit/' + (folder + '/' if folder else '')
        of_file = [test for test in self._seconds if test.startswith(mirror + 'test_' + name[:-3])]
        if place.in_function:
            numbers = range(place.line, place.end_line + 1)
            groups = [{test for number in numbers for test in lines.get(str(number), [])}, of_file]
        else:
            groups = [of_file, {test for tests in lines.values() for test in tests},
                      [test for test in self._seconds if test.startswith(mirror)
                       or os.path.dirname(test.split('::')[0]) == 'test/unit']]
        found: List[str] = []
        for group in groups:
            found += sorted(set(group).difference(found), key=lambda test: self._seconds[test])
        return found


class Equivalents:
    """The mutants that change nothing, from test/equivalent_mutants.yaml."""

    def __init__(self, text: str):
        self._known = {(SOURCES + '/' + entry['file'], entry['line'], after)
                       for entry in yaml.safe_load(text) or [] for after in entry['becomes']}

    def __contains__(self, mutant: Mutant) -> bool:
        key = (mutant.place.file, mutant.before, mutant.after)
        return key in self._known or key[:2] + ('anything',) in self._known


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


def recorded(tree: Tree, worker: Worker, folder: str) -> Record:
    """Run the tests without a mutant, but for files for which that was done already."""
    paths = {name: os.path.join(folder, 'records', digest + '.json')
             for name, digest in tree.test_files().items()}
    missing = [name for name, path in paths.items() if not os.path.isfile(path)]
    if missing:
        print('[mutants] running the tests of {} files once'.format(len(missing)), flush=True)
        os.makedirs(os.path.join(folder, 'records'), exist_ok=True)
        whole = os.path.join(folder, 'record.json')
        if worker.ask(record=whole, files=missing) != 0:
            sys.exit('[mutants] tests fail without a mutant: see {}.log'.format(worker.copy))
        with open(whole) as stream:
            record = json.load(stream)
        for name in missing:
            part = {'seconds': {test: value for test, value in record['seconds'].items()
                                if test.startswith(name + '::')},
                    'lines': {file: {line: [test for test in tests if test.startswith(name + '::')]
                                     for line, tests in lines.items()}
                              for file, lines in record['lines'].items()}}
            with open(paths[name], 'w') as stream:
                json.dump(part, stream)
    return Record(paths.values())


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
