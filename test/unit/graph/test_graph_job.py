"""graph.py as a user runs it."""
import os
import signal
import subprocess
import sys

import pytest

from img_recog.graph import graph_job
from img_recog.graph.system import Edge, System

SYSTEM = System(frozenset(['/a', '/b', '/rosout']), frozenset([
    Edge('/a', '/t', True), Edge('/b', '/t', False), Edge('/a', '/leaf', True),
    Edge('/a', '/rosout', True), Edge('/rosout', '/rosout', False)]))


@pytest.fixture
def draw(monkeypatch, tmp_path, capsys, handlers_as_before):
    """A function that runs the tool in a folder; it returns exit code, file and output."""
    reads = []

    class Reader:
        def read(self):
            reads.append(1)
            return SYSTEM._replace(rates_hz={Edge('/a', '/t', True): 10.0 * len(reads)})
    monkeypatch.setattr(graph_job, 'SystemReader', Reader)
    monkeypatch.setenv('PWD', str(tmp_path))

    def run(*arguments):
        code = graph_job.main([*arguments])
        path = tmp_path / 'out.dot'
        return code, path.read_text() if path.exists() else '', capsys.readouterr()
    return run


def test_a_picture_of_what_rqt_graph_shows(draw, tmp_path):
    code, text, output = draw('out.dot', '--seconds', '0.01')
    assert code == 0 and output.out == str(tmp_path / 'out.dot') + '\n'
    assert '"node /a" -> "topic /t" [label="20 Hz"]' in text
    assert '/leaf' not in text and '/rosout' not in text


def test_leaves_and_all(draw):
    assert '/leaf' in draw('out.dot', '--leaves', '--seconds', '0')[1]
    text = draw('out.dot', '--all', '--seconds', '0')[1]
    assert '"topic /leaf"' in text and '"node /rosout"' in text


@pytest.mark.parametrize('arguments, words', [
    (['out.gif'], "got 'out.gif', expected a path that ends in .dot, .png, .svg"),
    (['out'], 'expected a path'), ([], 'FILE'),
    (['out.dot', '--seconds', '-1'], 'expected a number of seconds'),
    (['out.dot', '--seconds', 'nan'], 'expected a number of seconds'),
    (['out.dot', '--seconds', 'x'], "got 'x'")])
def test_options_that_are_refused(draw, capsys, arguments, words):
    with pytest.raises(SystemExit):
        draw(*arguments)
    assert words in capsys.readouterr().err


def test_a_path_that_cannot_be_written(draw, tmp_path):
    (tmp_path / 'out.dot').mkdir()
    code = graph_job.main(['out.dot', '--seconds', '0'])
    assert code == 1


@pytest.mark.parametrize('uri, problem', [
    ('http://127.0.0.1:1', 'no master answers at http://127.0.0.1:1'),
    ('junk', "ROS_MASTER_URI is 'junk', expected http://HOST:PORT; set it to ")])
def test_without_a_master(monkeypatch, caplog, handlers_as_before, uri, problem):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    assert graph_job.main(['out.svg']) == 1
    assert caplog.messages[0].startswith(problem)


# a signal arrives while the file is written
INTERRUPTED = """
import contextlib, signal, sys
from img_recog.graph import graph_job
from img_recog.graph.system import System
signal.signal(signal.SIGINT, signal.SIG_DFL)        # as the script does
write = graph_job.files.atomic_write

class Reader:
    def read(self):
        return System(frozenset(), frozenset())

@contextlib.contextmanager
def atomic_write(*arguments):
    with write(*arguments) as outputs:
        signal.raise_signal(int(sys.argv[1]))
        yield outputs

graph_job.SystemReader, graph_job.files.atomic_write = Reader, atomic_write
sys.exit(graph_job.main(['out.dot', '--seconds', '0']))
"""


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_leaves_no_unfinished_file(tmp_path, signum):
    done = subprocess.run([sys.executable, '-c', INTERRUPTED, str(int(signum))],
                          cwd=str(tmp_path), env=dict(os.environ, PWD=str(tmp_path)),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    assert (done.returncode, done.stdout) == (128 + signum, b'')
    assert list(tmp_path.iterdir()) == []
