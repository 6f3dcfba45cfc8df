"""What of a file cannot be used."""
import pytest

from img_recog.simulation.descriptions.problems import Problems
from img_recog.simulation.settings import SimulationError
from img_recog_testing.refusals import refusal


def test_all_is_named_once_with_what_helps():
    problems = Problems()
    for problem, advice in (('mesh model://a', ''), ('<pose> of b', 'mend it'),
                            ('mesh model://a', ''), ('c', 'mend it')):
        with problems.left_out():
            raise SimulationError(problem, advice)
    assert problems.names == ('mesh model://a', '<pose> of b', 'c')
    assert refusal(problems.refuse, 'world w', 'leave it') == (
        'world w: not found, or not supported: mesh model://a, <pose> of b, c; mend it, or set '
        'GAZEBO_MODEL_PATH to the folders of the models, or leave it')
    assert problems.warnings('world w') == [
        'world w: loaded without: mesh model://a, <pose> of b, c']


def test_without_a_problem_nothing_is_refused():
    problems = Problems()
    with problems.left_out():
        pass
    problems.refuse('world w', 'leave it')
    assert problems.warnings('world w') == []


def test_other_errors_are_not_left_out():
    problems = Problems()
    with pytest.raises(KeyError), problems.left_out():
        raise KeyError('a')
    assert problems.names == ()
