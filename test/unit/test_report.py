"""Findings, and the views of their list."""
import pytest

from img_recog.errors import SimulationError
from img_recog.report import (ASSUMED, LEFT_OUT, NOT_DRAWN, NOT_FOUND, NOT_USED, NOTE, Finding,
                              Report)
from img_recog_helpers.refusals import refusal


def test_all_is_named_once_with_what_helps():
    report = Report('world w')
    for problem, advice in (('mesh model://a', ''), ('<pose> of b', 'mend it'),
                            ('mesh model://a', ''), ('c', 'mend it')):
        with report.left_out():
            raise SimulationError(problem, advice)
    assert report.of(LEFT_OUT) == ['mesh model://a', '<pose> of b', 'c']
    assert refusal(report.refuse, 'leave it') == (
        'world w: not found, or not supported: mesh model://a, <pose> of b, c; mend it, or set '
        'GAZEBO_MODEL_PATH to the folders of the models, or leave it')
    assert report.lines() == [
        'world w: loaded without: mesh model://a, <pose> of b, c; mend it; set GAZEBO_MODEL_PATH '
        'to the folders of the models']


def test_without_a_problem_nothing_is_refused():
    report = Report('world w')
    with report.left_out():
        pass
    report.refuse('leave it')
    assert report.lines() == [] and not report.is_partial


def test_other_errors_are_not_left_out():
    report = Report()
    with pytest.raises(KeyError), report.left_out():
        raise KeyError('a')
    assert report.findings == ()


@pytest.mark.parametrize('problem, advice', [
    ('model://a', 'set GAZEBO_MODEL_PATH to the folders of the models'),
    ('material Shop/Red', 'set GAZEBO_MODEL_PATH to the folders of the models'),
    ('material Gazebo/Red', ''), ('the material Shop/Red', ''),
    ('mesh file://a.stl', 'set GAZEBO_RESOURCE_PATH to the folders from which their paths start'),
    ('mesh file:///a.stl', ''),
    ('mesh package://a', 'build the packages and source their setup.bash'),
    ('https://a (a URL, which is not downloaded)',
     'download the models and include them by model://NAME')])
def test_what_helps(problem, advice):
    report = Report('w')
    report.add(NOT_FOUND, problem)
    report.add(NOT_FOUND, problem)
    report.refuse('o')
    assert report.lines() == ['w: not found, drawn in another color: ' + problem + (
        '; ' + advice if advice else '')]
    report.add(LEFT_OUT, problem)
    assert refusal(report.refuse, 'o') == (
        'w: not found, or not supported: {}; {}'.format(problem, advice)
        + (', or o' if advice else 'o'))


def test_one_problem_with_two_advices_is_named_once():
    report = Report('w')
    report.add(LEFT_OUT, 'door', advice='open it')
    report.add(LEFT_OUT, 'door', advice='shut it')
    assert report.lines() == ['w: loaded without: door; open it; shut it']


def test_equal_findings_are_one_with_all_places():
    report = Report()
    for place in 'abcde':
        report.about('robot.urdf').add(NOT_USED, '<mu>', 'link ' + place)
    assert report.lines() == ['robot.urdf: not used: <mu> of link a, link b, link c and 2 more']


def test_sentences_are_lines_of_their_own_and_assumed_values_are_none():
    report = Report('r')
    report.add(NOTE, 'it falls')
    report.assume('inertia of link a', 'it is small')
    assert report.lines() == ['r: it falls', 'r: it is small']
    assert report.of(ASSUMED) == ['inertia of link a'] and not report.is_partial


def test_the_owner_alone_is_refused():
    report = Report('world w')
    report.about('robot.urdf').add(LEFT_OUT, 'mesh a')
    report.refuse('leave it')
    assert report.is_partial


def test_a_listener_gets_what_is_added_later():
    report, lines = Report('w'), []
    report.add(NOTE, 'before')
    report.listen(lines.append)
    report.about('m').add(NOT_DRAWN, 'mesh b')
    report.extend([Finding(NOT_USED, 'x'), Finding(NOT_USED, 'y', owner='n')])
    assert lines == ['m: not drawn: mesh b', 'w: not used: x', 'n: not used: y']
    assert report.lines() == ['w: before'] and report.is_partial
