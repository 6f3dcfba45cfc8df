"""The text for graphviz, and its pictures."""
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.errors import UserError
from img_recog.graph import dot
from img_recog.graph.system import Edge, System

EDGES = (Edge('/usb_cam', '/usb_cam/image_raw', True),
         Edge('/tb/eye', '/usb_cam/image_raw', False),
         Edge('/tb/eye', '/tf', True), Edge('/tb/eye', '/tf_static', True))
SYSTEM = System(frozenset(['/usb_cam', '/tb/eye']), frozenset(EDGES),
                rates_hz={EDGES[0]: 29.96, EDGES[2]: 5.0, EDGES[3]: 0.0})


def test_the_lines_of_a_graph():
    lines = [line.strip() for line in dot.to_dot(SYSTEM).splitlines()]
    assert lines[0] == 'digraph system {' and lines[-1] == '}'
    assert [line for line in lines if '->' in line] == [
        '"node /tb/eye" -> "topic /tf" [label="5.0 Hz"];',
        '"topic /usb_cam/image_raw" -> "node /tb/eye" [label=""];',
        '"node /usb_cam" -> "topic /usb_cam/image_raw" [label="30 Hz"];']
    start = lines.index('subgraph "cluster_/usb_cam" {')
    assert lines[start + 1] == 'label="/usb_cam";'
    assert lines[start + 2].startswith('"topic /usb_cam/image_raw" [label="/usb_cam/image_raw"')
    assert lines[start + 3] == '}'
    # the node is beside the frame of its topics, and in that of its own namespace
    assert sum(line.startswith('"node /usb_cam" [') for line in lines[:start]) == 1
    assert lines[lines.index('subgraph "cluster_/tb" {') + 2].startswith('"node /tb/eye" [')
    assert sum('shape="box3d"' in line for line in lines) == 1


def test_a_namespace_within_a_namespace_is_a_frame_in_a_frame():
    edge = Edge('/n', '/a/b/c', True)
    text = dot.to_dot(System(frozenset(['/n']), frozenset([edge])))
    assert text.index('"cluster_/a" {') < text.index('"cluster_/a/b" {') < text.index(
        '"topic /a/b/c" [')
    assert text.count('}') == 3


def test_names_cannot_break_out_of_their_quotes():
    name = '/a"]; x -> y [label="\\'
    text = dot.to_dot(System(frozenset([name]), frozenset()))
    assert '"node /a\\"]; x -> y [label=\\"\\\\"' in text


def test_a_node_that_does_not_answer_is_marked():
    text = dot.to_dot(System(frozenset(['/n']), frozenset(), dead=frozenset(['/n'])))
    assert '/n (does not answer)' in text and 'color="red"' in text


@pytest.mark.parametrize('rate_hz, text', [
    (0.25, '0.2 Hz'), (9.94, '9.9 Hz'), (9.96, '10 Hz'), (1000.4, '1000 Hz')])
def test_rates(rate_hz, text):
    assert dot.rate_text(rate_hz) == text


def test_the_text_itself_needs_no_graphviz(monkeypatch):
    monkeypatch.setattr(shutil, 'which', lambda _: None)
    assert dot.draw('digraph {}', 'dot') == b'digraph {}'
    with pytest.raises(UserError, match='no program dot; install the package graphviz'):
        dot.draw('digraph {}', 'svg')


def test_a_picture_has_all_names():
    picture = ElementTree.fromstring(dot.draw(dot.to_dot(SYSTEM), 'svg'))
    texts = {text.text for text in picture.iter('{http://www.w3.org/2000/svg}text')}
    assert texts >= {'/usb_cam', '/tb/eye', '/usb_cam/image_raw', '/tf', '/tb', '30 Hz'}
    assert dot.draw(dot.to_dot(SYSTEM), 'png').startswith(b'\x89PNG')


def test_errors_of_graphviz_are_one_line(monkeypatch):
    with pytest.raises(UserError, match='^cannot draw the graph: dot ended with 1: [^\n]*syntax'):
        dot.draw('digraph {', 'svg')

    def late(command, timeout, **_):
        raise subprocess.TimeoutExpired(command, timeout)
    monkeypatch.setattr(subprocess, 'run', late)
    with pytest.raises(UserError, match='timed out'):
        dot.draw('digraph {}', 'svg')
