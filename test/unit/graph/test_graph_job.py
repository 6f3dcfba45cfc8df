"""graph.py as a user runs it."""
import pytest

from img_recog.graph import graph_job
from img_recog.graph.reader import Edge, System

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
    monkeypatch.setattr(graph_job, 'SECONDS', 0.0)
    monkeypatch.setenv('PWD', str(tmp_path))

    def run(*arguments):
        code = graph_job.main([*arguments])
        path = tmp_path / 'out.dot'
        return code, path.read_text() if path.exists() else '', capsys.readouterr()
    return run


def test_a_picture_of_what_rqt_graph_shows(draw, tmp_path):
    code, text, output = draw('out.dot')
    assert code == 0 and output.out == str(tmp_path / 'out.dot') + '\n'
    assert '"node /a" -> "topic /t" [label="20 Hz"]' in text
    assert '/leaf' not in text and '/rosout' not in text


def test_all(draw):
    text = draw('out.dot', '--all')[1]
    assert '"topic /leaf"' in text and '"node /rosout"' in text


@pytest.mark.parametrize('arguments, words', [
    (['out.gif'], "got 'out.gif', expected a path that ends in .dot, .png, .svg"),
    (['out'], 'expected a path'), ([], 'FILE')])
def test_options_that_are_refused(draw, capsys, arguments, words):
    with pytest.raises(SystemExit):
        draw(*arguments)
    assert words in capsys.readouterr().err


def test_a_path_that_cannot_be_written(draw, tmp_path):
    (tmp_path / 'out.dot').mkdir()
    assert graph_job.main(['out.dot']) == 1


@pytest.mark.parametrize('uri, problem', [
    ('http://127.0.0.1:1', 'no master answers at http://127.0.0.1:1'),
    ('junk', "ROS_MASTER_URI is 'junk', expected http://HOST:PORT; set it to ")])
def test_without_a_master(monkeypatch, caplog, handlers_as_before, uri, problem):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    assert graph_job.main(['out.svg']) == 1
    assert caplog.messages[0].startswith(problem)
