"""Free places for robots in a world."""
import dataclasses
import heapq
import math
from typing import Sequence

from img_recog.errors import SimulationError
from img_recog.settings import SettingError
from img_recog.simulation.physics import standing
from img_recog.simulation.physics.body import Body
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.simulated_model import Robot

_GRID_M = 0.25              # less than a wall and the clearance on both sides of it
_CLEARANCE_M = 0.1          # to what stands in the world
_ROBOT_CLEARANCE_M = 0.25   # to other robots
_MAX_TRIED = 10000
_MAX_CLIMB_M = 0.05         # from one point of the grid to the next


def start_apart(simulator: Simulator, robot: Robot) -> None:
    """Let a robot start at the free place nearest to its start, with the same z_pos and yaw.

    It can drive there from its start around all that stands in the world.
    Raises SimulationError when there is no such place.
    """
    start = robot.settings.spawn
    robots = [each.body for each in simulator.robots if each is not robot]
    # (distance to the start, column, row, height of the place before): the nearest first
    waiting, known = [(0.0, 0, 0, robot.lift.height_m)], {(0, 0)}
    for _ in range(_MAX_TRIED):
        if not waiting:
            break
        _, column, row, height_m = heapq.heappop(waiting)
        try:
            place = dataclasses.replace(start, x_pos=start.x_pos + column * _GRID_M,
                                        y_pos=start.y_pos + row * _GRID_M)
        except SettingError:        # too far away
            continue
        robot.set_start(place)
        climb_m = abs(robot.lift.height_m - height_m)
        if climb_m > _MAX_CLIMB_M or _is_at_wall(robot.body, simulator.world.scenery):
            continue
        if not standing.is_near(robot.body, robots, _ROBOT_CLEARANCE_M):
            return
        for cell in ((column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)):
            if cell not in known:
                known.add(cell)
                heapq.heappush(waiting, (math.hypot(*cell), *cell, robot.lift.height_m))
    if len(known) == 1:
        raise SimulationError('x {:g} m, y {:g} m, where the search for a free place begins, is '
                              'too near to a wall'.format(start.x_pos, start.y_pos),
                              'give it another x_pos and y_pos')
    raise SimulationError('there is no free place for it near x {:g} m, y {:g} m'.format(
        start.x_pos, start.y_pos), 'start fewer robots, or give it x_pos and y_pos')


def _is_at_wall(robot: Body, bodies: Sequence[Body]) -> bool:
    """Return whether a robot is near to something other than what it stands on.

    It is looked for as far above the robot's place as it may be away.
    """
    height_m = _CLEARANCE_M + standing.MAX_DEPTH_M
    robot.raise_by(height_m)
    is_near = standing.is_near(robot, bodies, _CLEARANCE_M)
    robot.raise_by(-height_m)
    return is_near
