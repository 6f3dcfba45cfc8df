"""The one way to build a simulator: of robots, their settings and a world.

loading/assemble.py reads the files for it. Nothing is logged: what is not done is in a report.
"""
import dataclasses
import heapq
import math
from typing import Callable, Sequence

from img_recog.errors import SimulationError, one_line, shortened
from img_recog.formats import drive_tags
from img_recog.formats.world_file import WorldFile
from img_recog.model import Tree
from img_recog.report import NOT_SIMULATED, NOTE, Report
from img_recog.settings import SettingError
from img_recog.simulation import configured_model, wheels
from img_recog.simulation.configured_model import ConfiguredModel, refusals
from img_recog.simulation.physics import standing
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import all_or_nothing, connect
from img_recog.simulation.physics.robot import check_motors
from img_recog.simulation.physics.world import World
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulation_settings import PhysicsSettings, whole_steps
from img_recog.simulation.simulated_model import MountedSensors, Robot, SimulatedModel
from img_recog.simulation.simulator import Simulator

_GRID_M = 0.25              # less than a wall and the clearance on both sides of it
_CLEARANCE_M = 0.1          # to what stands in the world
_ROBOT_CLEARANCE_M = 0.25   # to other robots
_MAX_TRIED = 10000
_MAX_CLIMB_M = 0.05         # from one point of the grid to the next


def build(physics: PhysicsSettings, world: WorldFile,
          robots: Sequence[ConfiguredModel], unused_sensors: Sequence[str] = (),
          option_name: Callable[[str], str] = str,
          kinds: Sequence[SensorKind] = (), with_bare: bool = False,
          with_drives: bool = False) -> Simulator:
    """Build a simulator of robots in a world, whose report has what is not done as its files ask.

    unused_sensors: kinds of sensors that are disabled. option_name: what the user types to give
    the setting of that name, for warnings. kinds: of the sensors that models of the world can
    have. with_bare: whether they count without a plugin. with_drives: whether models of the world
    that have a drive become robots.
    Raises SimulationError when PyBullet cannot load something or the settings do not fit.
    """
    physics_client_id = connect()
    driven = {number: tree for number, tree in enumerate(world.trees)
              if with_drives and drive_tags.is_driven(tree.model)}
    world = world._replace(trees=tuple(tree for number, tree in enumerate(world.trees)
                                       if number not in driven))
    report = Report('world ' + world.name)
    for robot in robots:
        report.extend(robot.findings)
    simulated_world = World(physics, world, physics_client_id, report, SimulatedModel)
    if not physics.allow_partial_world:
        report.refuse('set {} to load the rest'.format(option_name('allow_partial_world')))
    report.extend(world.findings)
    simulator = Simulator(simulated_world)
    for robot in robots:
        add_robot(simulator, robot, report, unused_sensors)
        _look_at_place(simulator.robots[-1], simulated_world, report)
    for tree in driven.values():
        _add_driven(simulator, tree, kinds, with_bare, report)
    for overlap in simulator.overlaps():
        report.about(overlap).add(
            NOTE, 'they overlap at the start, and the physics will throw them apart; set '
            + ', '.join(map(option_name, ('x_pos', 'y_pos', 'z_pos'))))
    for model in simulator.models:
        add_sensors(simulated_world, model, kinds, with_bare)
    return simulator


def _add_driven(simulator: Simulator, tree: Tree, kinds: Sequence[SensorKind],
                with_bare: bool, report: Report) -> None:
    """Add a model of the world as a robot.

    If its drive or a sensor cannot be used, the model is added as it is, and `add_sensors` finds
    the reason.
    """
    try:
        spec = configured_model.from_sdf(tree, simulator.world.step_s, kinds, with_bare)
        add_robot(simulator, spec, report)
        report.extend(spec.findings)
    except SimulationError:
        simulator.world.load([tree], report)


def add_sensors(world: World, model: SimulatedModel, kinds: Sequence[SensorKind],
                with_bare: bool = False) -> None:
    """Add the sensors that the file of a model of the world has; a robot has them already.

    The report of the world gets what is not simulated of the drive and the sensors.

    Args:
        world: World of the model.
        model: Model.
        kinds: Kinds of sensors; none for models without sensors.
        with_bare: Whether sensors without a plugin are simulated, too.
    """
    for tree, body in zip(model.trees, model.bodies):
        if model.is_robot or not (kinds and tree.model.tags):
            continue
        try:
            spec = configured_model.from_sdf(tree, world.step_s, kinds, with_bare)
            drive = spec.settings.drive
            if drive.is_there:      # one that could not drive as its file says is refused
                whole_steps('drive_period_s', drive.drive_period_s, world.step_s)
                with refusals(spec.source):
                    check_motors(spec.new_drive().motors, body)
            # what has no place belongs to a drive, which only a robot has
            spec = spec._replace(sensors=tuple(each for each in spec.sensors if each.place))
            mounted = MountedSensors(spec, world, body)
        except SimulationError as error:
            world.report.about('model ' + tree.name).add(
                NOT_SIMULATED, 'its sensors' + ' and its drive' * drive_tags.is_driven(tree.model),
                advice=one_line(error))
            continue
        world.report.extend(spec.findings)
        if spec.sensors:
            model.sensors.append(mounted)


def add_robot(simulator: Simulator, spec: ConfiguredModel, report: Report,
              unused_sensors: Sequence[str] = ()) -> None:
    """Load a robot into the world of a simulator.

    report: gets what is simulated in another way than asked; it has the findings of `spec`, or
    will get them. Other arguments and errors as for `build`; after an error, nothing has changed.
    """
    with refusals(spec.source), all_or_nothing(simulator.world.physics_client_id):
        robot = Robot(spec, simulator.world)
    simulator.world.add([robot])
    unused = [each.name for each in spec.sensors if each.kind.name in unused_sensors]
    for sensor in unused:
        robot.mounted.set_enabled(sensor, False)
    drive = spec.settings.drive
    report = report.about(spec.source)
    for line in wheels.measure(spec.model, drive).warnings(drive, spec.tag_values):
        report.add(NOTE, line)
    if not drive.is_there:
        others = [each.what for each in spec.findings if each.what.startswith(
            ('plugin', 'controller'))]
        report.add(NOTE, 'it does not drive, as it has no drive that is simulated{}; {}'.format(
            '; it has: {}'.format(shortened(', '.join(others))) if others else '',
            drive_tags.ADVICE))
    for each in spec.sensors:
        link = robot.mounted.missing.get(each.name, '')
        if link and each.name not in unused:
            what = 'sensor {}: no link {}'.format(each.name, link)
            if each.values:
                report.add(NOT_SIMULATED, what)
            else:
                report.assume('no ' + what, 'it runs without the ' + what)


def add_robot_apart(simulator: Simulator, spec: ConfiguredModel, report: Report) -> None:
    """Add a robot like `add_robot`, but not inside of a wall or another robot.

    Raises SimulationError also when there is no place.
    """
    add_robot(simulator, spec, report)
    robot = simulator.robots[-1]
    try:
        with refusals(spec.source):
            others = simulator.overlapped(robot.body) if spec.has_place else []
            if others:
                raise SimulationError('it would start inside of {}'.format(', '.join(others)),
                                      'give it another x_pos, y_pos or z_pos')
            if not spec.has_place:
                _start_apart(simulator, robot)
    except SimulationError:
        simulator.world.remove(robot)
        raise
    _look_at_place(robot, simulator.world, report)


def _start_apart(simulator: Simulator, robot: Robot) -> None:
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


def _look_at_place(robot: Robot, world: World, report: Report) -> None:
    """Say that a robot was lifted, is below a terrain or falls."""
    report = report.about(robot.body.name)
    if robot.lift.onto:
        report.add(NOTE, 'at z_pos {:g} m it would be in {}; it was lifted onto it by {:.3f} m'
                   .format(robot.settings.spawn.z_pos, robot.lift.onto, robot.lift.height_m))
    below, _ = standing.first_in_line(robot.body, upward=False)
    above, height_m = standing.first_in_line(robot.body, upward=True)
    for body in world.scenery:
        if body.body_id == above and (body.is_terrain or below == -1):
            report.add(NOTE, 'it starts below {}, which is at {:.3f} m there; set z_pos'.format(
                body.name, height_m))
            return
    if below == -1:
        report.add(NOTE, 'it falls, as nothing is below it: the world has no ground_plane or '
                   'other floor there')
