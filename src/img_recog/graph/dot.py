"""Draws a graph by graphviz: its text for `dot`, and the picture."""
import shutil
import subprocess
from typing import Dict, List, NamedTuple, Optional

from img_recog.errors import UserError, one_line
from img_recog.graph.reader import TF_TOPICS, System, clusters_of

FORMATS = ('dot', 'png', 'svg')
_TIMEOUT_S = 30.0
_FONT = 'DejaVu Sans, Helvetica, sans-serif'
_TF = '/tf'             # the name of the box for both topics of tf


class Colors(NamedTuple):
    """Colors of a picture, as graphviz reads them."""

    background: str = 'white'
    line: str = 'black'
    node: str = 'white'
    topic: str = 'white'
    dead: str = 'red'


def to_dot(system: System, colors: Colors = Colors()) -> str:
    """Return the text of a graph: nodes as ellipses, topics as boxes, a frame per namespace.

    >>> from img_recog.graph.reader import Edge
    >>> odom = Edge('/gazebo', '/odom', is_published=True)
    >>> system = System(frozenset(['/gazebo']), frozenset([odom]), rates_hz={odom: 30.0})
    >>> '"node /gazebo" -> "topic /odom" [label="30 Hz"];' in to_dot(system)
    True
    """
    members: Dict[tuple, List[str]] = {}

    def add(kind: str, name: str, shape: str, fill: str, is_dead: bool = False) -> None:
        members.setdefault(clusters_of(name), []).append(_line(
            _quoted(kind + ' ' + name), label=name + ' (does not answer)' * is_dead, shape=shape,
            style='filled', fillcolor=fill, color=colors.dead if is_dead else colors.line))
    for node in sorted(system.nodes):
        add('node', node, 'ellipse', colors.node, node in system.dead)
    for topic in sorted({_drawn(topic) for topic in system.topics}):
        add('topic', topic, 'box3d' if topic == _TF else 'box', colors.topic)
    text = {'color': colors.line, 'fontcolor': colors.line, 'fontname': _FONT}
    return '\n'.join([
        'digraph system {', _line('graph', rankdir='LR', bgcolor=colors.background, ranksep='0.3',
                                  **text), _line('node', **text), _line('edge', **text),
        *_cluster_lines((), members), *_edge_lines(system), '}', ''])


def draw(text: str, kind: str) -> bytes:
    """Return the picture of a graph's text; kind: one of FORMATS.

    Raises UserError if graphviz is missing or fails.
    """
    if kind == 'dot':
        return text.encode()
    program = shutil.which('dot')
    if program is None:
        raise UserError('cannot draw the graph: there is no program dot',
                        'install the package graphviz, or write a file .dot')
    try:
        done = subprocess.run([program, '-T' + kind], input=text.encode(), timeout=_TIMEOUT_S,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UserError('cannot draw the graph: {}'.format(one_line(error)))
    if done.returncode:
        raise UserError('cannot draw the graph: dot ended with {}: {}'.format(
            done.returncode, one_line(done.stderr.decode(errors='replace'))))
    return done.stdout


def rate_text(rate_hz: Optional[float]) -> str:
    """Return a rate with its unit, with two digits at least; empty if it is not known.

    >>> rate_text(29.97), rate_text(5.0), rate_text(0.0), rate_text(None)
    ('30 Hz', '5.0 Hz', '0 Hz', '')
    """
    if rate_hz is None:
        return ''
    if not rate_hz:
        return '0 Hz'
    return '{:.0f} Hz'.format(rate_hz) if rate_hz >= 9.95 else '{:.1f} Hz'.format(rate_hz)


def _cluster_lines(path: tuple, members: Dict[tuple, List[str]]) -> List[str]:
    """Return the lines of a namespace and of those in it."""
    lines = list(members.get(path, ()))
    for each in sorted({each[:len(path) + 1] for each in members
                        if len(each) > len(path) and each[:len(path)] == path}):
        lines += ['subgraph {} {{'.format(_quoted('cluster_' + each[-1])),
                  'label={};'.format(_quoted(each[-1])), *_cluster_lines(each, members), '}']
    return lines


def _edge_lines(system: System) -> List[str]:
    """Return the lines of the edges; those of both topics of tf are one."""
    rates_hz: Dict[tuple, List[float]] = {}
    for edge in sorted(system.edges):
        ends = _quoted('node ' + edge.node), _quoted('topic ' + _drawn(edge.topic))
        known = rates_hz.setdefault(ends if edge.is_published else ends[::-1], [])
        known += [system.rates_hz[edge]] if edge in system.rates_hz else []
    return [_line('{} -> {}'.format(*ends), label=rate_text(max(known, default=None)))
            for ends, known in rates_hz.items()]


def _drawn(topic: str) -> str:
    """Return the name under which a topic is drawn."""
    return _TF if topic in TF_TOPICS else topic


def _line(what: str, **attributes: str) -> str:
    return '{} [{}];'.format(what, ', '.join(
        '{}={}'.format(name, _quoted(value)) for name, value in attributes.items()))


def _quoted(text: str) -> str:
    return '"{}"'.format(text.replace('\\', '\\\\').replace('"', '\\"'))
