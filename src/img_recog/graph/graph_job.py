"""The command line of graph.py: a picture of the running system."""
import os
import time
from typing import List, Optional, Sequence

from img_recog import files
from img_recog.command_line import programs
from img_recog.command_line.programs import allowed
from img_recog.graph import dot
from img_recog.graph.reader import SystemReader, visible

SECONDS = 2.0          # in which rates are measured


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the tool; return its exit code."""
    return programs.run('graph.py', _draw, words=arguments)


def _draw(words: List[str], _: object) -> str:
    parser = programs.parser(
        'graph.py', 'Draw the nodes and topics of the running system to a file, like rqt_graph '
        'with "Nodes/Topics (all)", with the rate of each topic.')
    parser.add_argument('output', metavar='FILE', type=allowed(
                            str, lambda path: _kind(path) in dot.FORMATS,
                            'a path that ends in .' + ', .'.join(dot.FORMATS)),
                        help='where to write the picture: FILE.svg, FILE.png, or FILE.dot for '
                        'graphviz')
    parser.add_argument('--all', action='store_true',
                        help='also show topics that only one node uses or that nobody subscribes '
                        'to, /rosout, /clock, the topics of dynamic_reconfigure and nodes that do '
                        'not answer')
    options, reader = parser.parse_args(words), SystemReader()
    reader.read()
    time.sleep(SECONDS)
    system = reader.read()
    picture = dot.draw(dot.to_dot(system if options.all else visible(system)),
                       _kind(options.output))
    path = files.user_output_path(options.output)
    with files.atomic_write([path], 'give a path that can be written') as (file,):
        file.write(picture)
    return path


def _kind(path: str) -> str:
    return os.path.splitext(path)[1].lower()[1:]
