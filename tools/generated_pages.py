#!/usr/bin/env python3
"""Write what is made from the code in the pages of doc/.

usage: ./run shell python3 tools/generated_pages.py

That is all of doc/launch.md, from the launch files; all of doc/elements.md, from the table of
elements; and in doc/reference.md, of each parameter of a node, its name, default and allowed
values, from its settings. What a parameter means is written by hand, and stays; a new one is added
below the others of its node, without a meaning.
"""
import dataclasses
import os
import re
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Tuple

import launch_files

from img_recog.camera.usb_cam_settings import UsbCamSettings, ControlSettings
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.formats import elements
from img_recog.nodes.color_extract.color_extract_node import InputSettings
from img_recog.nodes.gazebo.lockstep_settings import LockstepSettings
from img_recog.nodes.gazebo.robot_reader import RobotsSettings, robot_settings_classes
from img_recog.nodes.gazebo.stepping import SteppingSettings
from img_recog.nodes.republish import RepublishSettings
from img_recog.nodes.robots.robot_list import NodeSettings
from img_recog.nodes.robots.robots_node import ManagerSettings
from img_recog.nodes.web.web_settings import WebSettings
from img_recog.recognition.recognition_settings import DEFAULT_COLORS, with_colors
from img_recog.settings import SettingError
from img_recog.simulation.simulation_settings import PhysicsSettings, ViewSettings
from img_recog.teleoperation.teleop_settings import TeleopSettings, VelocityLimits

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
_LAUNCH = """# Launch files

The arguments of each launch file in `launch/`. `./run demo --help` lists those of the demo, or
without `./run`, `roslaunch --ros-args img_recog demo.launch`. `demo.launch` starts the parts below
it and hands its arguments to them; on the command line, it takes those of the parts too
(`./run demo web_port:=8090`). A launch file of your own that includes it and sets an argument of a
part needs `<include ... pass_all_args="true">`. Each part works alone:
`roslaunch img_recog simulator.launch`. This page is written by `tools/generated_pages.py`.
"""
_ELEMENTS = """# Elements of robots and worlds

What becomes of each element of SDF (1.4 to 1.9) and of URDF with `<gazebo>` tags.
`check_world.py`, `check_robot.py` and the log say what a file has of the last column, what is
misspelt, and what is in no row. An element with `=` is only named if it has another value than
that. This page is written by `tools/generated_pages.py`.
"""
_ROW = re.compile(r'\| `(\w+)` \|(?:[^|]*\|){2}(.*)')
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
    'image_republisher': Node('republish', (RepublishSettings,)),
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
    folder = os.path.join(ROOT, 'launch')
    roots = launch_files.with_parts(os.path.join(folder, 'demo.launch'))
    for name in (*roots, 'robot.launch', 'machines.launch'):
        root = roots.get(name) or launch_files.read(os.path.join(folder, name))
        yield from ('', '## ' + name, '')
        if name != 'demo.launch':
            yield from (launch_files.head(root), '')
        yield from ('| argument | default | meaning |', '|---|---|---|')
        for each in launch_files.arguments(root).values():
            default = {None: 'required', '': 'empty'}.get(
                each.default, '`{}`'.format(each.default))
            yield '| `{}` | {} | {} |'.format(each.name, default, each.doc)


def _elements() -> Iterator[str]:
    for title, table in (('SDF', elements.SDF), ('URDF', elements.URDF)):
        yield from ('', '## ' + title, '',
                    '| in | simulated or drawn | of no effect here | not simulated |',
                    '|---|---|---|---|')
        for path, row in table.items():
            if not row.anything:
                yield '| `{}` | {} | {} | {} |'.format(
                    path, _words(row.simulated + ' ' + row.drawn),
                    _words(row.no_effect) + (' ({})'.format(row.why) if row.why else ''),
                    _words(row.not_simulated))


def _words(text: str) -> str:
    return ' '.join('`{}`'.format(word.rstrip('?')) for word in text.split())


def parameters(node: Node) -> Dict[str, str]:
    """Return the beginning of the row of each parameter of a node, by its name."""
    return {field.name: '| `{}` | {} | {} |'.format(
        field.name, _shown(field.default), _allowed(settings, field.name))
        for settings in node.settings for field in dataclasses.fields(settings)
        if 'allowed' in field.metadata}


def _shown(value: Any) -> str:
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return '`{}`'.format(text) if text else 'empty'


def _allowed(settings: _Settings, name: str) -> str:
    """Return the allowed values from the error about a refused value."""
    try:
        settings(**{name: object()})
    except SettingError as refused:
        return refused.allowed
    raise AssertionError('{} takes anything'.format(name))


def with_parameters(lines: Iterable[str]) -> List[str]:
    """Return the lines of the reference with the rows of all parameters as they are to be."""
    found: List[str] = []
    left: Dict[str, str] = {}       # of the node of this chapter, that have no row yet
    others: Tuple[str, ...] = ()
    end, is_table = 0, False        # where the last table with parameters ends
    for line in [*lines, '## ']:
        if line.startswith('## '):
            found[end:end] = [row + ' |' for row in left.values()]
            node = NODES.get(line[3:], Node('', ()))
            left, others, end = parameters(node), node.others, 0
        row = _ROW.match(line) if is_table else None
        if row and row.group(1) in left:
            line = '{} {}'.format(left.pop(row.group(1)), row.group(2).strip())
        elif row and row.group(1) not in others:
            continue
        is_table = line.startswith('|') and (
            is_table or line.startswith('| name | default | allowed |'))
        found.append(line)
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
