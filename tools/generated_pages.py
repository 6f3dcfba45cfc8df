#!/usr/bin/env python3
"""Write what is made from the code in the pages of doc/.

usage: ./run shell python3 tools/generated_pages.py

That is all of doc/launch.md, from the launch files; all of doc/elements.md, from the
schema; and in doc/reference.md, default and allowed values of each parameter of a node, from its
settings. What a parameter means is written by hand, and stays; a new one is added below the others
of its node, without a meaning. Names that are written in one row stay there, as long as the same
values are allowed.
"""
import collections
import dataclasses
import os
import re
import textwrap
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Tuple

import launch_files

from img_recog.camera.usb_cam_settings import UsbCamSettings, ControlSettings
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.formats import reader, schema
from img_recog.nodes.color_extract.color_extract_node import InputSettings
from img_recog.nodes.gazebo.lockstep import LockstepSettings
from img_recog.nodes.gazebo.physics_services import SteppingSettings
from img_recog.nodes.gazebo.robot_reader import RobotsSettings, robot_settings_classes
from img_recog.nodes.robots.robot_list import NodeSettings
from img_recog.nodes.robots.robots_node import ManagerSettings
from img_recog.nodes.web.shown_robots import WebSettings
from img_recog.recognition.recognition_settings import DEFAULT_COLORS, with_colors
from img_recog.settings import allowed_text
from img_recog.simulation.simulation_settings import PhysicsSettings, ViewSettings
from img_recog.teleoperation import TeleopSettings, VelocityLimits

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
_LAUNCH = """# Launch files

`demo.launch` includes the other files, but for `robot.launch` and `machines.launch`, and hands its
arguments to them. On the command line, it takes theirs too (`./run demo web_port:=8090`). A launch
file of your own that includes it and sets an argument of another file needs
`<include ... pass_all_args="true">`. Each file works alone: `roslaunch img_recog camera.launch`.
`./run demo --help` lists the arguments of the demo, or without `./run`,
`roslaunch --ros-args img_recog demo.launch`. This page is written by `tools/generated_pages.py`.
"""
_ELEMENTS = """# Elements of robots and worlds

How each element of SDF (1.4 to 1.9) and of URDF with `<gazebo>` tags is handled.

`check_world.py`, `check_robot.py` and the log name the elements of a file that are in the last
column, and the elements that are in no row. They name an element with `=` only if its value
differs from the one shown. The types of values are in the last table.
`tools/generated_pages.py` writes this page.
"""
_ROW = re.compile(r'\| (`\w+`(?:, `\w+`)*) \|(?:[^|]*\|){2}(.*)')
_DEMO = 'The whole system of the article.'
_WIDTH = 120        # of a line of text
_Settings = Any         # a class of settings


class Node(NamedTuple):
    """A chapter of the reference.

    module: in img_recog.nodes; others: parameters that are in none of the settings.
    """

    module: str
    settings: Tuple[_Settings, ...]
    others: Tuple[str, ...] = ()


NODES: Dict[str, Node] = {
    'usb_cam': Node('usb_cam.usb_cam_node', (UsbCamSettings, ControlSettings, CompressionSettings),
                    ('intrinsic_controls',)),
    'color_extract': Node('color_extract.color_extract_node', (InputSettings, with_colors()), (
        'colors', *(name + '_image_topic' for name in DEFAULT_COLORS))),
    'gazebo': Node('gazebo.gazebo_node', (
        PhysicsSettings, ViewSettings, RobotsSettings, LockstepSettings, SteppingSettings,
        *robot_settings_classes())),
    'turtlebot3_teleop_keyboard': Node('teleop_key', (TeleopSettings,)),
    'robots': Node('robots.robots_node', (ManagerSettings, NodeSettings)),
    'web': Node('web.web_node', (WebSettings, VelocityLimits))}


def written() -> Dict[str, str]:
    """Return the pages by their paths, as they are to be."""
    with open(os.path.join(ROOT, 'doc', 'reference.md'), encoding='utf-8') as file:
        reference = file.read()
    return {'doc/launch.md': _LAUNCH + _text(_launch_arguments()),
            'doc/elements.md': _ELEMENTS + _text(_elements()),
            'doc/reference.md': _text(with_parameters(reference.splitlines()))}


def _text(lines: Iterable[str]) -> str:
    return ''.join(line + '\n' for line in lines)


def _launch_arguments() -> Iterator[str]:
    """Yield a table of the files, and one of all arguments: what differs by file has more rows."""
    folder = os.path.join(ROOT, 'launch')
    roots = launch_files.with_parts(os.path.join(folder, 'demo.launch'))
    for name in ('robot.launch', 'machines.launch'):
        roots[name] = launch_files.read(os.path.join(folder, name))
    files: Dict[launch_files.Argument, List[str]] = {}
    yield from ('', '## Files', '', '| file | what it starts | arguments |', '|---|---|---|')
    for name, root in roots.items():
        taken = launch_files.arguments(root)
        for each in taken.values():
            files.setdefault(each._replace(group=''), []).append(name)
        yield '| `{}` | {} | {} |'.format(
            name, _DEMO if name == 'demo.launch' else launch_files.head(root),
            _words(' '.join(taken)))
    yield from ('', '## Arguments', '', '| argument | default | meaning |', '|---|---|---|')
    counts = collections.Counter(each.name for each in files)
    for each, names in sorted(files.items(), key=lambda item: item[0].name):
        default = {None: 'required', '': 'empty'}.get(each.default, '`{}`'.format(each.default))
        place = 'in {}: '.format(_words(' '.join(names))) if counts[each.name] > 1 else ''
        yield '| `{}` | {} | {}{} |'.format(each.name, default, place, each.doc)


def _elements() -> Iterator[str]:
    both = {path: row for path, row in schema.SDF.items() if schema.URDF.get(path) == row}
    for title, table in (('SDF and URDF', both), ('SDF', schema.SDF), ('URDF', schema.URDF)):
        places: Dict[Tuple[str, str, str], List[str]] = {}      # what has the same row
        for path, row in table.items():
            if not row.anything and (table is both or path not in both):
                places.setdefault((
                    _words(row.simulated + ' ' + row.drawn),
                    _words(row.no_effect) + (' ({})'.format(row.why) if row.why else ''),
                    _words(row.not_simulated)), []).append(path)
        whole = {cells: paths for cells, paths in places.items() if not any(cells[1:])}
        yield from ('', '## ' + title, '',
                    '| in | simulated or drawn | of no effect here | not simulated |',
                    '|---|---|---|---|')
        for cells, paths in places.items():
            if cells not in whole:
                yield '| {} | {} |'.format(_words(' '.join(paths)), ' | '.join(cells))
        yield ''
        yield from textwrap.wrap('All is simulated or drawn in ' + '; '.join(
            '{}: {}'.format(_words(' '.join(paths)), simulated)
            for (simulated, *_), paths in whole.items()) + '.', _WIDTH)
    yield from ('', '## Types of values', '', '| type | allowed |', '|---|---|')
    for name, each in sorted({**reader.TYPES, '3numbers': reader.type_of('3numbers'),
                              '3lengths': reader.type_of('3lengths'),
                              '3sizes': reader.type_of('3sizes')}.items()):
        yield '| {} | {} |'.format(name, each.allowed)


def _words(text: str) -> str:
    """Return words of the schema as a text of the page: `mass` (mass, default 1)."""
    def shown(word: str) -> str:
        name, has_type, rest = word.partition(':')
        kind, has_default, default = rest.partition('=')
        return '`{}`'.format(name) + ' ({}{})'.format(
            kind, ', default ' * bool(has_default) + default.replace(',', ' ')) * bool(has_type)
    return ' '.join(map(shown, text.split()))


class Parameter(NamedTuple):
    """What the page says of a parameter, but for its meaning."""

    name: str
    default: str
    allowed: str


def parameters(node: Node) -> Dict[str, Parameter]:
    """Return the parameters of a node, by name."""
    return {field.name: Parameter(field.name, _shown(field.default), allowed_text(field))
            for settings in node.settings for field in dataclasses.fields(settings)
            if 'allowed' in field.metadata}


def _rows(of_row: Iterable[Parameter], meaning: str) -> Iterator[str]:
    """Yield a row of parameters, or one for each kind of allowed values."""
    by_allowed: Dict[str, List[Parameter]] = {}
    for each in of_row:
        by_allowed.setdefault(each.allowed, []).append(each)
    for allowed, found in by_allowed.items():
        defaults = [each.default for each in found]
        yield '| {} | {} | {} |{}'.format(
            ', '.join('`{}`'.format(each.name) for each in found),
            ', '.join(defaults if len(set(defaults)) > 1 else defaults[:1]), allowed, meaning)


def _shown(value: Any) -> str:
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return '`{}`'.format(text) if text else 'empty'


def with_parameters(lines: Iterable[str]) -> List[str]:
    """Return the lines of the reference with the rows of all parameters as they are to be."""
    found: List[str] = []
    left: Dict[str, Parameter] = {}     # of the node of this chapter, that have no row yet
    others: Tuple[str, ...] = ()
    end, is_table = 0, False        # where the last table with parameters ends
    for line in [*lines, '## ']:
        if line.startswith('## '):
            for each in reversed(list(left.values())):
                found[end:end] = _rows([each], ' |')
            node = NODES.get(line[3:], Node('', ()))
            left, others, end = parameters(node), node.others, 0
        row = _ROW.match(line) if is_table else None
        names = row.group(1).strip('`').split('`, `') if row else []
        if row and not set(names) & set(others):
            found += _rows([left.pop(name) for name in names if name in left],
                           ' ' + row.group(2).strip())
        else:
            found.append(line)
        is_table = line.startswith('|') and (
            is_table or line.startswith('| name | default | allowed |'))
        if is_table:
            end = len(found)
    return found[:-1]


def main() -> None:
    """Write the pages."""
    for path, text in written().items():
        with open(os.path.join(ROOT, path), 'w', encoding='utf-8') as file:
            file.write(text)


if __name__ == '__main__':
    main()
