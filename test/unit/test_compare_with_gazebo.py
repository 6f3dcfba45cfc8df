"""The tools that compare robots and worlds with Gazebo: their rules and their tables."""
import importlib
import json
import os

import pytest

from img_recog.errors import UserError

from img_recog_helpers.pages import ROOT

STILL = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(ROOT, 'tools'))
    return importlib.import_module


@pytest.fixture
def robots(load):
    return load('compare_robots')


@pytest.fixture
def cases(load):
    return load('compare_cases')


@pytest.mark.parametrize('ours, gazebo, tolerance, expected', [
    (0.66, 0.6, 0.02, True), (0.661, 0.6, 0.02, False), (0.54, 0.6, 0.02, True),
    (0.019, 0.0, 0.02, True), (0.021, 0.0, 0.02, False),        # 10 % of nothing is nothing
    (-1.35, -1.5, 0.03, True), (1.5, -1.5, 0.03, False)])
def test_agreement_is_10_percent_or_the_tolerance(robots, ours, gazebo, tolerance, expected):
    assert robots.agrees(ours, gazebo, tolerance) is expected


@pytest.mark.parametrize('command, gazebo, ours, turns_wrongly, strays', [
    ('turn', (0.0, 1.5), (0.0, 1.4), False, False),
    ('turn', (0.0, 1.5), (0.03, 0.74), True, True),
    ('turn', (0.03, 1.5), (0.04, 3.1), True, False),     # it moves in Gazebo, too
    ('both', (0.6, 1.5), (0.7, -1.5), True, False),
    ('straight', (0.6, 0.01), (0.6, 0.05), False, False)])      # neither turns
def test_wrong_turns_are_listed(robots, command, gazebo, ours, turns_wrongly, strays):
    found = robots.Comparison('a', command, 0.0, gazebo, ours)
    assert (found.turns_wrongly, found.strays) == (turns_wrongly, strays)


def test_tables_of_robots(robots):
    found = robots.compare('a', {'turn': [(0.0, 1.5)] * 4}, {'turn': [(0.0, 1.5)] * 3 + [
        (0.1, 0.5)]})
    assert [each.heading for each in found] == list(robots.HEADINGS)
    assert robots.share(found) == 0.75
    assert list(robots.table(found))[-2:] == [
        '  turn           0.3      0.000     0.000       1.500     1.500',
        '  turn         0.785      0.000     0.100*      1.500     0.500*']
    assert list(robots.markdown(found))[2:] == ['| a | 75% | 0.33 |', '| all | 75% | 0.33 |']


@pytest.mark.parametrize('ratios, expected', [
    ((1.1, 0.8), 0.8), ((1.5, 0.8), 1.5), ((-1.0, 9.0), -1.0)])
def test_worst_ratio_is_farthest_from_1_as_a_factor(robots, ratios, expected):
    assert robots.worst_yaw_ratio([robots.Comparison('a', 'turn', 0.0, (0.0, 1.0), (0.0, ratio))
                                   for ratio in ratios]) == expected


def test_list_of_robots_has_values_of_gazebo(load, robots):
    listed = load('public_robots').read_list()
    assert len(listed) >= 15
    with open(robots.IN_GAZEBO) as file:
        in_gazebo = json.load(file)
    for robot in listed:
        assert {command: len(each) for command, each in in_gazebo[robot.name].items()} == {
            command: len(robots.HEADINGS) for command in robots.COMMANDS}, robot.name
    with pytest.raises(UserError, match='there is no robot nobody'):
        load('public_robots').read_list(['nobody'])


def test_reversed_joints_turn_backward(load):
    robot = load('public_robots').Robot('a', 'b/c', '', 'd.urdf', ['l', 'm'], ['r'], 0.2, 0.4, 5.0,
                                        0.0, reversed=['m'])
    assert {joint: pytest.approx(velocity) for joint, velocity in robot.motors('both')} == {
        'l': 1.0, 'm': -1.0, 'r': 3.0}


def test_world_of_an_sdf_keeps_its_version(load, tmp_path):
    """In SDF 1.7, <use_parent_model_frame> does nothing: wheels turned about another axis."""
    (tmp_path / 'b+c').mkdir()
    (tmp_path / 'b+c' / 'd.sdf').write_text('<sdf version="1.5"><model name="m"/></sdf>')
    robot = load('public_robots').Robot('a', 'b/c', '', 'd.sdf', ['l'], ['r'], 0.2, 0.4, 5.0, 0.0)
    folder = load('public_robots').write_worlds(robot, str(tmp_path), 'false')
    with open(folder + '/turn_0.sdf') as file:
        assert file.read().startswith('<sdf version="1.5">')


def test_values_follow_more_than_one_turn(load):
    quarters = [(0, 0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 0, 1, 1), (0, 0, 0, 0, 0, 1, 0),
                (0, 0, 0, 0, 0, 1, -1), (0, 0, 0, 0, 0, 0, -1), (3, 4, 9, 0, 0, 1, 1)]
    assert load('public_robots').motion(quarters) == (5.0, 7.854)


def test_runs_of_cases(cases, tmp_path):
    (tmp_path / 'cases').mkdir()
    (tmp_path / 'cases' / 'push.sdf').write_text('<sdf/>')
    (tmp_path / 'cases.json').write_text(json.dumps({
        'push': {'until': 2, 'drive': 'm::a=1:5 m::b=-1:5', 'vel': 'hit=2,0,0',
                 'urdf': 'r.urdf', 'twist_of_the_product': [0, 1.5]},
        'no_world': {'urdf': 'r.urdf', 'twist_of_the_product': [0.2, 0]}}))
    push, robot, other = cases.read_runs(str(tmp_path))
    assert push.words()[1:] == ['--until', '2.0', '--every', '2.0', '--drive', 'm::a=1:5',
                                '--drive', 'm::b=-1:5', '--velocity', 'hit=2,0,0']
    assert push.is_in_gazebo and not robot.is_in_gazebo and not other.is_in_gazebo
    assert (robot.name, robot.until_s, other.name) == ('push robot', 2.0, 'no_world robot')
    assert robot.words()[-1] == '--twist=0,1.5'
    with pytest.raises(UserError, match='there is no case pull'):
        cases.read_runs(str(tmp_path), ['pull'])


def test_change_says_whether_a_link_is_nearer_to_gazebo(cases):
    def states(**heights):
        return {'run': {'links': {'m::' + name: [0.0, 0.0, height, *STILL[3:]]
                                  for name, height in heights.items()}}}

    before = states(nearer=1.0, farther=1.0, other_side=1.0, same=1.0, alone=1.0)
    after = states(nearer=1.5, farther=0.5, other_side=3.0, same=1.0009, alone=2.0)
    gazebo = states(nearer=2.0, farther=2.0, other_side=2.0, same=2.0)
    assert {(each.link, each.verdict) for each in cases.changes(before, after, gazebo)} == {
        ('m::nearer', 'nearer'), ('m::farther', 'farther'), ('m::other_side', 'as far'),
        ('m::alone', '')}
    assert list(cases.change_lines(before, after, gazebo))[-1] == (
        '4 links have changed in 1 runs: 1 nearer to Gazebo, 1 farther, 1 as far, 1 not in Gazebo')


def test_turned_links_and_errors_are_changes(cases):
    before = {'turned': {'links': {'m::l': STILL}}, 'refused': {'links': {'m::l': STILL}},
              'renamed': {'links': {'m::l': STILL}}}
    after = {'turned': {'links': {'m::l': [*STILL[:5], 0.0015, 1.0]}},
             'refused': {'error': 'no such file'}, 'renamed': {'links': {'m::k': STILL}}}
    change, = cases.changes(before, after, {})
    assert (change.run, change.moved_m) == ('turned', 0.0) and 0.0029 < change.turned_rad < 0.0031
    lines = list(cases.change_lines(before, after, {}))
    assert lines[:3] == ['refused: error before: none; error now: no such file',
                         'renamed: missing now: m::l', 'renamed: new: m::k']


def test_difference_names_the_worst_link_and_those_of_one_side(cases):
    line = cases.difference_line(
        'case', {'links': {'a::b': STILL, 'a::c': STILL, 'a::ours': STILL}},
        {'links': {'a::b': [0.0, 0.0, 0.5, *STILL[3:]], 'a::c': STILL, 'a::theirs': STILL}})
    assert line.split() == (
        'case 0.5000 m 0.0000 rad a::b; only in img_recog: a::ours; only in Gazebo: a::theirs'
    ).split()


def test_gazebo_program_that_prints_no_state_is_an_error(load, tmp_path):
    program = tmp_path / 'run'
    program.write_text('#!/bin/sh\necho "no such world" >&2\n')
    program.chmod(0o755)
    with pytest.raises(UserError, match='Gazebo cannot run a.sdf: no such world'):
        load('gazebo_runs').GazeboProgram(str(program)).run('a.sdf', 1.0, 1.0)


def test_gazebo_program_gets_the_arguments_of_simulate(load, tmp_path):
    program = tmp_path / 'run'
    program.write_text('#!/bin/sh\necho \'{"t": 1, "links": {}, "joints": {"j": [-nan]}}\'\n'
                       'echo "{\\"words\\": \\"$*\\"}"\n')
    program.chmod(0o755)
    state, words = load('gazebo_runs').GazeboProgram(str(program), '21345').run(
        'a.sdf', 1.0, 0.5, ['m::j=1:5'], ['m=1,0,0'])
    assert words['words'] == ('a.sdf --until 1.0 --every 0.5 --port 21345 --drive m::j=1:5 '
                              '--velocity m=1,0,0')
    assert state['joints']['j'][0] != state['joints']['j'][0]       # not a number
