"""Makes a package of the user from the one in templates/; the command line of new_package.py."""
import contextlib
import importlib.machinery
import os
import pathlib
import re
import shutil
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from typing import List

import rospkg

from img_recog.command_line import programs
from img_recog.errors import UserError, one_line

_TEMPLATE = 'my_robot_vision'       # also the word that is replaced by the name


def main() -> int:
    """Make the package that the command line names; return the exit code."""
    return programs.run('new_package.py', _make)


def _make(words: List[str], _: object) -> str:
    parser = programs.parser(
        'new_package.py', 'Make a package with a node that drives a robot by the images of its '
        'camera, tests of it in the simulator, and files for CI.')
    parser.add_argument('name', metavar='NAME', help='of the package, its node and its files')
    parser.add_argument('folder', metavar='DIR', help='where to make it: src of a workspace')
    options = parser.parse_args(words)
    return 'made the package {}'.format(make(options.name, options.folder))


def make(name: str, folder: str) -> pathlib.Path:
    """Copy the template to a new folder of that name in `folder`, with the name in it.

    Returns the path of the package. Raises UserError.
    """
    own = pathlib.Path(rospkg.RosPack().get_path('img_recog'))
    _check_name(name, own)
    target = _check_folder(name, folder)
    try:
        with tempfile.TemporaryDirectory(prefix='.' + name, dir=str(target.parent)) as temporary:
            made = pathlib.Path(temporary, name)
            _copy(own / 'templates' / _TEMPLATE, made, name)
            made.rename(target)
    except OSError as error:
        raise UserError('cannot make {}: {}'.format(target, one_line(error)))
    return target


def _check_name(name: str, own: pathlib.Path) -> None:
    """own: the folder of this package."""
    if not re.fullmatch('[a-z][a-z0-9_]*[a-z0-9]', name):     # REP 144
        raise UserError('got the name {!r}'.format(name), 'a package name has small letters, '
                        'digits and underscores, and begins with a letter')
    with contextlib.suppress(rospkg.ResourceNotFound):
        path = rospkg.RosPack().get_path(name)
        raise UserError('there is a package {} in {}'.format(name, path), 'choose another name')
    # without the folder of this program
    if name in sys.builtin_module_names or importlib.machinery.PathFinder.find_spec(
            name, sys.path[1:]) is not None:
        raise UserError('the node would be {}.py, and there is a Python module {}'.format(
            name, name), 'choose another name')
    for launch in sorted((own / 'launch').glob('*.launch')):
        if name in {node.get('name') for node in ElementTree.parse(str(launch)).iter('node')}:
            raise UserError('{} has a node {}'.format(launch.name, name), 'choose another name')


def _check_folder(name: str, folder: str) -> pathlib.Path:
    """Return the path of the new package."""
    parent = pathlib.Path(folder).expanduser().absolute()
    if not parent.is_dir():
        raise UserError('there is no folder {}'.format(parent), 'make it first')
    if os.path.lexists(str(parent / name)):
        raise UserError('{} exists'.format(parent / name), 'choose another name or folder')
    for each in (parent, *parent.parents):
        if (each / 'package.xml').exists():
            raise UserError('{} is in the package {}, where ROS finds no other'.format(
                parent, each), 'give the folder src of a workspace')
    return parent / name


def _copy(template: pathlib.Path, target: pathlib.Path, name: str) -> None:
    """Copy a folder, with `name` in the place of the template's in paths and texts."""
    shutil.copytree(str(template), str(target), ignore=shutil.ignore_patterns('__pycache__'))
    for path in [*target.rglob('*')]:
        if not path.is_file():
            continue
        text = path.read_text(encoding='utf-8').replace(_TEMPLATE, name)
        path.write_text(text, encoding='utf-8')
        # in this package no program of the template is executable: rosrun would find it
        path.chmod(0o755 if text.startswith('#!') else 0o644)
        path.rename(path.with_name(path.name.replace(_TEMPLATE, name)))
