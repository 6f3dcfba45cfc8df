"""Free places for robots in a world."""
import dataclasses
import heapq
import math

import pybullet

from img_recog.settings import SettingError
from img_recog.simulation.bodies.body import Pose
from img_recog.simulation.settings import SimulationError, SpawnSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

_GRID_M = 0.25              # less than a wall and the clearance on both sides of it
_CLEARANCE_M = 0.1          # to what stands in the world
_ROBOT_CLEARANCE_M = 0.25   # to other robots
_MAX_TRIED = 10000


def find(simulator: Simulator, vehicle: Vehicle) -> SpawnSettings:
    """Return the free place nearest to where the vehicle starts, with the same z_pos and yaw.

    The vehicle can drive there from its start around all that stands in the world. It is moved.
    Raises SimulationError when there is no such place.
    """
    start = vehicle.settings.spawn
    walls = [body.body_id for body in simulator.world.bodies]
    robots = [each.robot.body_id for each in simulator.vehicles if each is not vehicle]
    # (distance to the start, column, row): the nearest first
    waiting, known = [(0.0, 0, 0)], {(0, 0)}
    for _ in range(_MAX_TRIED):
        if not waiting:
            break
        _, column, row = heapq.heappop(waiting)
        try:
            place = dataclasses.replace(start, x_pos=start.x_pos + column * _GRID_M,
                                        y_pos=start.y_pos + row * _GRID_M)
        except SettingError:        # too far away
            continue
        _move(vehicle, place)
        if _is_near(vehicle, walls, _CLEARANCE_M):
            continue
        if not _is_near(vehicle, robots, _ROBOT_CLEARANCE_M):
            return place
        for cell in ((column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)):
            if cell not in known:
                known.add(cell)
                heapq.heappush(waiting, (math.hypot(*cell), *cell))
    if len(known) == 1:
        raise SimulationError('x {:g} m, y {:g} m, where the search for a free place begins, is '
                              'too near to a wall'.format(start.x_pos, start.y_pos),
                              'give it another x_pos and y_pos')
    raise SimulationError('there is no free place for it near x {:g} m, y {:g} m'.format(
        start.x_pos, start.y_pos), 'start fewer robots, or give it x_pos and y_pos')


def _move(vehicle: Vehicle, place: SpawnSettings) -> None:
    pose = vehicle.robot.pose()
    vehicle.robot.place(Pose((place.x_pos, place.y_pos, place.z_pos), pose.orientation,
                             pose.joints))


def _is_near(vehicle: Vehicle, body_ids: 'list[int]', distance_m: float) -> bool:
    robot = vehicle.robot
    return any(pybullet.getClosestPoints(robot.body_id, body_id, distance_m,
                                         physicsClientId=robot.physics_client_id)
               for body_id in body_ids)
