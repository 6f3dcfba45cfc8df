"""What of a file cannot be used."""
import pytest

from img_recog.errors import SimulationError
from img_recog.formats.problems import Problems
from img_recog_helpers.refusals import refusal


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
    problems, looks = Problems(), Problems()
    problems.add(problem)
    looks.add_look(problem)
    looks.add_look(problem)
    ends = 'w: not found, or not supported: {}; {}'.format(problem, advice)
    assert refusal(problems.refuse, 'w', 'o') == ends + (', or o' if advice else 'o')
    assert (looks.names, looks.looks) == ((), (problem,))
    looks.refuse('w', 'o')
    assert looks.warnings('w') == ['w: not found, drawn in another color: ' + problem + (
        '; ' + advice if advice else '')]
    looks.add('door', 'open it')
    looks.add('door', 'shut it')
    assert looks.warnings('w')[0] == 'w: loaded without: door'
    assert refusal(looks.refuse, 'w', 'o').endswith(': door; open it, or o')
