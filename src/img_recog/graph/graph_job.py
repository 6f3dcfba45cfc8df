"""The command line of graph.py: a picture of the running system."""
import argparse
import os
import time
from typing import List, Optional, Sequence

from img_recog import files
from img_recog.command_line import programs
from img_recog.command_line.option_types import allowed
from img_recog.graph import dot
from img_recog.graph.reader import SystemReader
from img_recog.graph.system import visible

_SECONDS = 2.0          # in which rates are measured


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the tool; return its exit code."""
    return programs.run('graph.py', _draw, words=arguments)


def _draw(words: List[str], _: object) -> str:
    options, reader = _parser().parse_args(words), SystemReader()
    system = reader.read()
    if options.seconds:
        time.sleep(options.seconds)
        system = reader.read()
    shown = system if options.all else visible(system, options.leaves)
    picture = dot.draw(dot.to_dot(shown), _kind(options.output))
    path = files.user_output_path(options.output)
    with files.atomic_write([path], 'give a path that can be written') as (file,):
        file.write(picture)
    return path


def _parser() -> argparse.ArgumentParser:
    parser = programs.parser(
        'graph.py', 'Draw the nodes and topics of the running system to a file, like rqt_graph '
        'with "Nodes/Topics (all)", with the rate of each topic.')
    parser.add_argument('output', metavar='FILE', type=allowed(
                            str, lambda path: _kind(path) in dot.FORMATS,
                            'a path that ends in .' + ', .'.join(dot.FORMATS)),
                        help='where to write the picture: FILE.svg, FILE.png, or FILE.dot for '
                        'graphviz')
    parser.add_argument('--leaves', action='store_true',
                        help='also show topics that only one node uses or that nobody '
                        'subscribes to')
    parser.add_argument('--all', action='store_true',
                        help='also show these, /rosout, /clock, the topics of dynamic_reconfigure '
                        'and nodes that do not answer')
    parser.add_argument('--seconds', default=_SECONDS, metavar='S', type=allowed(
                            float, lambda seconds: 0 <= seconds < 3600,
                            'a number of seconds, 0 or more and below an hour'),
                        help='how long to measure rates; 0: draw none (default: %(default)g)')
    return parser


def _kind(path: str) -> str:
    return os.path.splitext(path)[1].lower()[1:]
