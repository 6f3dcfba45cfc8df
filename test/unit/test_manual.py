"""tools/manual: pillars of a map, the file of a map, and the wall that the robot follows."""
import importlib
import math
import os
import re
from types import SimpleNamespace

import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog_testing import turtlebot3_world
from img_recog_testing.pages import ROOT

ANGLES = np.radians(range(360))
CELL = 0.05


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(ROOT, 'tools', 'manual'))
    return importlib.import_module


def drawn(occupancy, centers):
    """Return a grid with circles, as a scanner sees the pillars."""
    cells, origin = np.full((120, 120), 0, np.int8), (-3.0, -3.0)
    cells[:10] = -1
    for x, y in centers:
        column = ((x + 0.15 * np.cos(ANGLES) - origin[0]) / CELL).astype(int)
        row = ((y + 0.15 * np.sin(ANGLES) - origin[1]) / CELL).astype(int)
        cells[row, column] = 100
    return occupancy.Grid(cells, CELL, origin)


def moved(degrees, shift):
    turn = math.radians(degrees)
    return [(x * math.cos(turn) - y * math.sin(turn) + shift,
             x * math.sin(turn) + y * math.cos(turn)) for x, y in turtlebot3_world.POSTS]


@pytest.mark.parametrize('centers, raw, aligned', [
    (moved(0, 0), 0.0, 0.0), (moved(0, 0.1), 0.1, 0.0),
    # 1.556 m from the middle
    (moved(4, 0), 1.556 * math.radians(4), 0.0),
    ([(0.15, 0), *(post for post in turtlebot3_world.POSTS if post != (0, 0))], 0.15, 0.133)])
def test_errors_of_pillars(tool, centers, raw, aligned):
    """A map that is only turned and shifted has the right shape."""
    occupancy, chapters = tool('occupancy'), tool('chapters')
    assert chapters.PILLARS == turtlebot3_world.POSTS
    found = occupancy.find_pillars(drawn(occupancy, centers), chapters.PILLARS, 0.15)
    assert len(found) == 9
    assert occupancy.errors(found) == pytest.approx((raw, aligned), abs=0.02)


def test_pillar_that_is_not_in_the_map_is_missing(tool):
    occupancy, chapters = tool('occupancy'), tool('chapters')
    grid = drawn(occupancy, turtlebot3_world.POSTS[1:])
    assert set(occupancy.find_pillars(grid, chapters.PILLARS, 0.15)) == set(
        turtlebot3_world.POSTS[1:])


def test_map_is_saved_as_map_server_reads_it(tool, tmp_path):
    occupancy = tool('occupancy')
    grid = occupancy.Grid(np.array([[0, 100, -1], [-1, 0, 30]], np.int8), 0.1, (-1.5, 2.0))
    occupancy.save(grid, str(tmp_path / 'map'))
    # the first row of the picture is the one of the largest y
    assert (tmp_path / 'map.pgm').read_bytes() == b'P5\n3 2\n255\n' + bytes(
        [205, 254, 205, 254, 0, 205])
    text = (tmp_path / 'map.yaml').read_text()
    assert 'image: map.pgm\nresolution: 0.1\norigin: [-1.5, 2, 0]\n' in text


def test_robot_goes_round_along_the_wall_and_hits_nothing(tool):
    explorer, (x, y), yaw = tool('explorer'), tool('chapters').START, 0.0
    turn, period_s, rays = explorer.Round((x, y)), 0.2, np.radians(range(0, 360, 8))
    quadrants = set()
    for _ in range(1500):
        ranges = turtlebot3_world.ranges(np.array((x, y)), rays + yaw, 3.5)
        speed, turning = explorer.command(ranges, 0.0, rays[1])
        yaw += turning * period_s
        x, y = x + speed * period_s * math.cos(yaw), y + speed * period_s * math.sin(yaw)
        # the radius of the burger
        assert turtlebot3_world.clearance((x, y)) > 0.105, (x, y, yaw)
        quadrants.add((x > 0, y > 0))
        if turn.is_complete((x, y)):
            break
    else:
        raise AssertionError('not back within 300 s, after {:.1f} m'.format(turn.driven_m))
    assert len(quadrants) == 4 and turn.driven_m > 8.0


@pytest.mark.parametrize('nothing', [math.inf, math.nan, 0.0])
def test_ranges_without_an_echo_are_free(tool, nothing):
    speed, turning = tool('explorer').command([nothing] * 360, 0.0, math.radians(1))
    assert speed > 0 and turning < 0        # it looks for the wall on its right


@pytest.mark.parametrize('is_reached, off_m, is_good', [
    (True, 0.07, True), (True, 0.13, False), (False, 0.05, False)])
def test_a_goal_is_reached_only_near_it(tool, capsys, is_reached, off_m, is_good):
    """The map is shifted by 0.2 m along x, and so is a goal in it."""
    grid = drawn(tool('occupancy'), moved(0, 0.2))
    end = tool('reader').Arrival(is_reached, 'words', (1.3 + off_m, -2.0), 12.3)
    reader = SimpleNamespace(localize=lambda start: None, drive_to=lambda goal: end,
                             grid=lambda is_new: grid)
    given = SimpleNamespace(goal=[(1.5, -2.0, 0.0)])
    assert tool('tasks').navigation(reader, given) == is_good
    line = re.search(r'goal 1.5 -2.0: words after 12 s, (\S+) m from it in the frame of the map, '
                     r'(\S+) m in the frame of the world', capsys.readouterr().out)
    assert float(line.group(1)) == pytest.approx(off_m, abs=0.025)
    assert float(line.group(2)) == pytest.approx(0.2 - off_m, abs=0.001)


def test_navigation_refuses_a_map_without_the_pillars(tool):
    grid = drawn(tool('occupancy'), turtlebot3_world.POSTS[1:])
    reader = SimpleNamespace(localize=lambda start: None, grid=lambda is_new: grid)
    with pytest.raises(UserError, match='only 8 of 9 pillars are in the map; make it: '):
        tool('tasks').navigation(reader, SimpleNamespace(goal=None))


def test_agent_turns_to_the_goal(tool):
    """The first action turns to the left, the last one to the right."""
    actions = [tool('learning').action_for([2.0, heading, 1.0, 0, 0])
               for heading in (3.0, 0.4, 0.0, -0.4, -3.0)]
    assert actions == [0, 1, 2, 3, 4]


def test_goals_collisions_and_resets_are_counted(tool, monkeypatch):
    learning, outcomes = tool('learning'), iter([
        (7.5, False), (200, False), (-200, True), (-3.0, False)])
    places = iter([((0.6, 0.0), True), ((-0.4, 1.1), False)])

    class Env(SimpleNamespace):
        state = [1.0, 0.0, 1.0, 0, 0]

        def reset(self):
            return self.state

        def step(self, action):
            assert action == 2
            return (self.state, *next(outcomes))
    monkeypatch.setattr(learning.rospy, 'get_time', iter([2.0, 9.5]).__next__)
    monkeypatch.setattr(learning, '_goal', lambda environment: next(places))
    result = learning._steps(SimpleNamespace(Env=lambda actions: Env()), 4, lambda: None)
    assert result == ([7.5, 200.0, -200.0, -3.0], [((0.6, 0.0), True, 2)], 1, 2, 7.5)


def course(tool):
    """Return the course of a lane along x: about y = 1, 0.1 m on its left, 0.14 m on the right."""
    picture = np.zeros((500, 400, 3), np.uint8)
    for y, color in ((1.1, (0, 255, 255)), (0.86, (255, 255, 255))):
        picture[int((2 + y) / 4 * 500)] = color
    return tool('course').Course(picture)


def test_lines_of_a_lane(tool):
    assert course(tool).lines(-1.7, 1.0) == pytest.approx((0.1, 0.14), abs=0.01)
    assert course(tool).lines(2.1, 1.0) == (math.inf, math.inf)


def test_drive_along_a_lane(tool):
    drive = tool('course').LaneDrive(course(tool))
    for x, y, degrees in ((0, 1, 0), (0.3, 1, 50), (0.3, 1, 100), (0.3, 0.96, 178)):
        drive.add(x, y, math.radians(degrees))
    assert (drive.corners, drive.is_inside) == (2, True)
    assert drive.driven_m == pytest.approx(0.34)
    assert drive.off_middle == pytest.approx([0.02, 0.02, 0.02, 0.02], abs=0.01)
    drive.add(0.3, 0.6, 0.0)
    assert not drive.is_inside and len(drive.off_middle) == 4
