"""Copies of the working tree, and the processes that run tests in them."""
import hashlib
import json
import os
import shutil
import subprocess
import sys
from typing import Dict, List

from mutations import Mutant

PURE = ('camera', 'conversions', 'recognition', 'rendering', 'replay', 'simulation',
        'teleoperation')
SOURCES = 'src/img_recog'
# what decides their results, beside their own file
SHARED = ('config/', 'src/', 'test/img_recog_testing/', 'test/unit/', 'tools/mutants/', 'urdf/')
# in test/unit; all others are run
OTHER_TESTS = ('nodes', 'ros', 'test_walls.py')


class Tree:
    """The files of the working tree."""

    def __init__(self, root: str):
        self._root = root
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
                if path[0] in PURE or (len(path) == 1 and path[0] != '__init__.py')]

    def test_files(self) -> Dict[str, str]:
        """Return the files with tests that are run, and a digest of all that decides each result.

        A pure file with examples in its docstrings is one of them.
        """
        tests = [name for name in self.files if name.startswith('test/unit/')
                 and os.path.basename(name).startswith('test_')
                 and name[len('test/unit/'):].split('/')[0] not in OTHER_TESTS]
        examples = [name for name in self.pure_files() if '>>> ' in self.source(name)]
        shared = hashlib.sha1()
        for name in self.files:
            if name.startswith(SHARED) and name not in tests:
                shared.update(name.encode() + self._content(name))
        return {name: hashlib.sha1(shared.digest() + self._content(name)).hexdigest()
                for name in tests + examples}

    def _content(self, name: str) -> bytes:
        with open(os.path.join(self._root, name), 'rb') as stream:
            return stream.read()

    def copy(self, path: str) -> str:
        """Make a copy with this path and return the path."""
        for file in self.files:
            os.makedirs(os.path.dirname(os.path.join(path, file)), exist_ok=True)
            shutil.copy2(os.path.join(self._root, file), os.path.join(path, file))
        return path


class Worker:
    """A copy of the tree and the process that runs tests in it."""

    def __init__(self, copy: str, python: str):
        self.copy = copy
        self._time_s = 0
        here = os.path.dirname(os.path.abspath(__file__))
        paths = [copy + '/src', copy + '/test', os.environ.get('PYTHONPATH', '')]
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(paths), ROS_PACKAGE_PATH=(
            copy + os.pathsep + os.environ.get('ROS_PACKAGE_PATH', '')))
        self._process = subprocess.Popen(
            [python, os.path.join(here, 'worker.py'), copy], env=environment,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True)

    def ask(self, **request) -> int:
        """Send a request to worker.py and return the exit code of the tests."""
        assert self._process.stdin is not None and self._process.stdout is not None
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
        shutil.copy2(path, self.copy + '.original')
        try:
            with open(path, 'w', encoding='utf-8') as stream:
                stream.write(mutant.source)
            # Python's cache of a file is valid for its size and its time in s
            self._time_s += 1
            os.utime(path, (self._time_s, self._time_s))
            code = self.ask(tests=tests, limits=limits)
        finally:
            shutil.copy2(self.copy + '.original', path)
        return code != 0

    def close(self) -> None:
        """End the process."""
        self._process.communicate()
