"""Compare what the simulator makes of robots and worlds with hashes that were written before.

usage: golden_hashes.py [--write] [FOLDER]

test/golden.txt has the hashes of the texts of golden.py: of this package's own files, and of
public ones, which are not kept here. Those are compared if FOLDER is given: it has a clone of each
repository of the list, at the commit there, in OWNER+NAME. Prints a line for each file that
differs: golden.py shows its text. --write writes the list again instead.
"""
import argparse
import os
import subprocess
import sys
from typing import Dict, Iterator, List, NamedTuple

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
LIST = os.path.join(ROOT, 'test', 'golden.txt')
_OWN = '.'
# of clones, the folders of models, like in GAZEBO_MODEL_PATH
_MODELS = 'ROBOTIS-GIT+turtlebot3_simulations/turtlebot3_gazebo/models', 'osrf+gazebo_models'


class Golden(NamedTuple):
    """A file with the hash of its text; repository, commit: '.' and '-' for an own file."""

    hash: str
    repository: str
    commit: str
    path: str


def read() -> List[Golden]:
    """Return the list."""
    with open(LIST) as file:
        return [Golden(*line.split()) for line in file if not line.startswith('#')]


def compared(goldens: List[Golden], folder: str = '') -> Iterator[str]:
    """Yield a line for each file whose hash is another one, or that is not there."""
    found = _hashes(goldens, folder)
    for each in goldens:
        if found.get(_place(each)) != each.hash:
            yield '{}: {}, expected {}'.format(_place(each), found.get(_place(each), 'not read'),
                                               each.hash)


def write(folder: str) -> None:
    """Write the hashes of now into the list."""
    goldens = read()
    found = _hashes(goldens, folder)
    with open(LIST) as file:
        head = [line for line in file if line.startswith('#')]
    with open(LIST, 'w') as file:
        file.writelines(head)
        for each in goldens:
            file.write(' '.join(each._replace(hash=found.get(_place(each), each.hash))) + '\n')


def _place(golden: Golden) -> str:
    return os.path.normpath(os.path.join(golden.repository.replace('/', '+'), golden.path))


def _hashes(goldens: List[Golden], folder: str) -> Dict[str, str]:
    """Return the hashes of files by their places, those of public ones if there is a folder."""
    found: Dict[str, str] = {}
    for is_own, start in ((True, ROOT), (False, folder)):
        places = [_place(each) for each in goldens if (each.repository == _OWN) == is_own]
        if start and places:
            found.update(_hashes_in(os.path.abspath(start), places, is_own))
    return found


def _hashes_in(folder: str, places: List[str], is_own: bool) -> Dict[str, str]:
    models = [] if is_own else [os.path.join(folder, each) for each in _MODELS]
    path = os.environ.get('ROS_PACKAGE_PATH', '') if is_own else os.pathsep.join(
        [folder, os.path.abspath(ROOT)])
    run = subprocess.run(
        [sys.executable, os.path.join(ROOT, 'tools', 'golden.py'), '--hashes', *places],
        cwd=folder, stdout=subprocess.PIPE, check=True, universal_newlines=True,
        env={**os.environ, 'ROS_PACKAGE_PATH': path, 'GAZEBO_RESOURCE_PATH': '',
             'GAZEBO_MODEL_PATH': os.pathsep.join(models)})
    return {words[-1]: words[0] for words in (line.split() for line in run.stdout.splitlines())
            if len(words) == 4}


def main() -> int:
    """Compare or write; return 1 if something differs."""
    parser = argparse.ArgumentParser(description='See the text at the head of this file.')
    parser.add_argument('--write', action='store_true')
    parser.add_argument('folder', nargs='?', default='', metavar='FOLDER')
    given = parser.parse_args()
    if given.write:
        write(given.folder)
        return 0
    lines = list(compared([each for each in read() if given.folder or each.repository == _OWN],
                          given.folder))
    print('\n'.join(lines) or 'no difference')
    return 1 if lines else 0


if __name__ == '__main__':
    sys.exit(main())
