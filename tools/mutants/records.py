"""Which tests run which line, and which mutants change nothing."""
import json
import os
import sys
from collections import defaultdict
from typing import Dict, Iterable, List

import yaml

from mutations import Mutant, Place
from trees import SOURCES, Tree, Worker


class Record:
    """Which tests run which line, and how long each takes."""

    def __init__(self, paths: Iterable[str]):
        self._seconds: Dict[str, float] = {}
        self._lines: Dict[str, Dict[int, List[str]]] = defaultdict(lambda: defaultdict(list))
        for path in paths:
            with open(path) as stream:
                record = json.load(stream)
            for test, (seconds, lines) in record.items():
                self._seconds[test] = seconds
                for file, numbers in lines.items():
                    for number in numbers:
                        self._lines[file][number].append(test)
        self.limits = {test: 10 + 5 * seconds for test, seconds in self._seconds.items()}

    def tests(self, place: Place) -> List[str]:
        """Return the tests for a place: groups of tests, and in each the fastest first.

        In a function: those that run it, then the other tests of its file (what is cached is run
        by the first test only). Other lines, and functions that no test calls, are run once, by
        the import: the tests of the file, those that run anything of it, all others of its top
        folder and of test/unit itself.
        """
        lines = self._lines[place.file]
        folder, name = os.path.split(os.path.relpath(place.file, SOURCES))
        mirror = 'test/unit/' + (folder + '/' if folder else '')
        top = 'test/unit/' + (folder.split('/')[0] + '/' if folder else '')
        of_file = [test for test in self._seconds if test.startswith(mirror + 'test_' + name[:-3])]
        numbers = range(place.line, place.end_line + 1)
        of_lines = {test for number in numbers for test in lines[number]}
        if place.in_function and of_lines:
            groups = [of_lines, of_file]
        else:
            groups = [of_file, {test for tests in lines.values() for test in tests},
                      [test for test in self._seconds if test.startswith(top)
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


def recorded(tree: Tree, worker: Worker, folder: str) -> Record:
    """Run the tests without a mutant, but for files for which that was done already."""
    paths = {name: os.path.join(folder, 'records', digest + '.json')
             for name, digest in tree.test_files().items()}
    missing = [name for name, path in paths.items() if not os.path.isfile(path)]
    if missing:
        print('[mutants] running the tests of {} files once'.format(len(missing)), flush=True)
        os.makedirs(os.path.join(folder, 'records'), exist_ok=True)
        whole = os.path.join(folder, 'record.json')
        if worker.ask(record=whole, files=missing) not in (0, 1):       # 1: some tests failed
            with open(worker.copy + '.log', errors='replace') as log:
                sys.exit('[mutants] the tests cannot be run:\n{}'.format(
                    ''.join(log.readlines()[-20:])))
        with open(whole) as stream:
            record = json.load(stream)
        for test in record['failed']:
            print('[mutants] not used, it fails without a mutant: {}'.format(test), flush=True)
        for name in missing:
            with open(paths[name], 'w') as stream:
                json.dump({test: value for test, value in record['tests'].items()
                           if test.startswith(name + '::')}, stream)
    return Record(paths.values())
