"""The text for graphviz, and its pictures."""
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.errors import UserError
from img_recog.graph import dot
from img_recog.graph.reader import Edge, System
from img_recog_helpers import expected

EDGES = (Edge('/usb_cam', '/usb_cam/image_raw', True),
         Edge('/tb/eye', '/usb_cam/image_raw', False),
         Edge('/tb/eye', '/tf', True), Edge('/tb/eye', '/tf_static', True),
         Edge('/usb_cam', '/a/b/c', True))      # a frame in a frame
HOSTILE = '/a"]; x -> y [label="\\'
SYSTEM = System(frozenset(['/usb_cam', '/tb/eye', HOSTILE, '/gone']), frozenset(EDGES),
                dead=frozenset(['/gone']),
                rates_hz={EDGES[0]: 29.96, EDGES[2]: 5.0, EDGES[3]: 0.0})


def test_the_text_of_a_graph():
    expected.check_printed('graph.dot', dot.to_dot(SYSTEM))


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
