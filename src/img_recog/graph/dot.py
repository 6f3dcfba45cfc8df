"""Draws a graph by graphviz: its text for `dot`, and the picture."""
import shutil
import subprocess
from typing import Dict, List, NamedTuple, Optional

from img_recog.errors import UserError, one_line
from img_recog.graph.system import TF_TOPICS, System, clusters_of

FORMATS = ('dot', 'png', 'svg')
_TIMEOUT_S = 30.0
_FONT = 'DejaVu Sans, Helvetica, sans-serif'
_TF = '/tf'             # the name of the box for both topics of tf
_INDENT = '  '


class Colors(NamedTuple):
    """Colors of a picture, as graphviz reads them."""

    background: str = 'white'
    line: str = 'black'
    node: str = 'white'
    topic: str = 'white'
    dead: str = 'red'


def to_dot(system: System, colors: Colors = Colors()) -> str:
    """Return the text of a graph: nodes as ellipses, topics as boxes, a frame per namespace.

    >>> from img_recog.graph.system import Edge
    >>> odom = Edge('/gazebo', '/odom', is_published=True)
    >>> system = System(frozenset(['/gazebo']), frozenset([odom]), rates_hz={odom: 30.0})
    >>> '"node /gazebo" -> "topic /odom" [label="30 Hz"];' in to_dot(system)
    True
    """
    members: Dict[tuple, List[str]] = {}
    for node in sorted(system.nodes):
        members.setdefault(clusters_of(node), []).append(_node_line(node, system, colors))
    for topic in sorted(system.topics - set(TF_TOPICS)):
        members.setdefault(clusters_of(topic), []).append('{} [label={}, shape=box, {}];'.format(
            _id('topic', topic), _quoted(topic), _fill(colors.topic)))
    if system.topics & set(TF_TOPICS):
        members.setdefault((), []).append('{} [label={}, shape=box3d, {}];'.format(
            _id('topic', _TF), _quoted(_TF), _fill(colors.topic)))
    lines = ['graph [rankdir=LR, bgcolor={}, color={}, fontcolor={}, fontname={}, ranksep=0.3];'
             .format(*map(_quoted, (colors.background, colors.line, colors.line, _FONT)))]
    lines += ['{} [color={}, fontcolor={}, fontname={}];'.format(
        kind, *map(_quoted, (colors.line, colors.line, _FONT))) for kind in ('node', 'edge')]
    lines += _cluster_lines((), members)
    lines += _edge_lines(system)
    return '\n'.join(['digraph system {'] + [_INDENT + line for line in lines] + ['}', ''])


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


def _node_line(node: str, system: System, colors: Colors) -> str:
    is_dead = node in system.dead
    return '{} [label={}, shape=ellipse, {}{}];'.format(
        _id('node', node), _quoted(node + (' (does not answer)' if is_dead else '')),
        _fill(colors.node), ', color=' + _quoted(colors.dead) if is_dead else '')


def _cluster_lines(path: tuple, members: Dict[tuple, List[str]]) -> List[str]:
    """Return the lines of a namespace and of those in it."""
    lines = list(members.get(path, ()))
    inner = sorted({each[:len(path) + 1] for each in members
                    if len(each) > len(path) and each[:len(path)] == path})
    for each in inner:
        lines.append('subgraph {} {{'.format(_quoted('cluster_' + each[-1])))
        lines += [_INDENT + line for line in
                  ['label={};'.format(_quoted(each[-1]))] + _cluster_lines(each, members)]
        lines.append('}')
    return lines


def _edge_lines(system: System) -> List[str]:
    """Return the lines of the edges; those of both topics of tf are one."""
    rates_hz: Dict[tuple, List[float]] = {}
    for edge in sorted(system.edges):
        ends = (_id('node', edge.node),
                _id('topic', _TF if edge.topic in TF_TOPICS else edge.topic))
        rate_hz = system.rates_hz.get(edge)
        rates_hz.setdefault(ends if edge.is_published else ends[::-1], []).extend(
            [] if rate_hz is None else [rate_hz])
    return ['{} -> {}{};'.format(*ends, ' [label={}]'.format(_quoted(rate_text(max(known))))
                                 if known else '') for ends, known in rates_hz.items()]


def _id(kind: str, name: str) -> str:
    return _quoted(kind + ' ' + name)


def _fill(color: str) -> str:
    return 'style=filled, fillcolor=' + _quoted(color)


def _quoted(text: str) -> str:
    return '"{}"'.format(text.replace('\\', '\\\\').replace('"', '\\"'))
