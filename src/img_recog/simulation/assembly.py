"""The one way to build a simulator: of robots, their settings and a world.

loading/assemble.py reads the files for it. Warnings are returned; nothing is logged.
"""
import contextlib
from typing import Callable, Iterator, List, NamedTuple, Sequence, Tuple

from img_recog.errors import SimulationError, UserError, one_line, shortened
from img_recog.formats import drive_tags
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.simulation import places, robot_spec
from img_recog.simulation.carrier import Carrier
from img_recog.simulation import wheels
from img_recog.simulation.physics import standing
from img_recog.simulation.physics.client import all_or_nothing, connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.pictures.scene import Scene, scene_of
from img_recog.simulation.robot_spec import RobotSpec
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle


class Assembly(NamedTuple):
    """A simulator, the scene of which copies can be drawn, and warnings, a line each.

    left_out: what of the world could not be read or loaded.
    """

    simulator: Simulator
    scene: Scene
    warnings: Tuple[str, ...]
    left_out: Tuple[str, ...] = ()


def build(physics: PhysicsSettings, world: WorldFile,
          robots: Sequence[RobotSpec], unused_sensors: Sequence[str] = (),
          option_name: Callable[[str], str] = str,
          kinds: Sequence[SensorKind] = (), with_bare: bool = False,
          with_drives: bool = False) -> Assembly:
    """Build a simulator of robots in a world.

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
    problems, name = Problems(), 'world {}'.format(world.name)
    simulated_world = World(physics, world, physics_client_id, problems)
    if not physics.allow_partial_world:
        problems.refuse(name, 'set {} to load the rest'.format(option_name('allow_partial_world')))
    warnings = [*(line for robot in robots for line in robot.warnings), *world.warnings,
                *problems.warnings(name), *(
                    '{}: model {}'.format(name, line) for line in simulated_world.warnings)]
    if simulated_world.crowded:
        warnings.append('{}: {}'.format(name, simulated_world.crowded))
    if simulated_world.lifted:
        warnings.append('world {}: at the start in the floor, and lifted onto it: {}'.format(
            world.name, ', '.join('{} by {:.3f} m'.format(*each)
                                  for each in simulated_world.lifted.items())))
    simulator = Simulator(simulated_world)
    for robot in robots:
        warnings += add_robot(simulator, robot, unused_sensors)
        warnings += _place_of(simulator.vehicles[-1], simulated_world)
    for tree in driven.values():
        robot = robot_spec.read_model(tree, physics.step_s, kinds, with_bare)
        warnings += [*robot.warnings, *add_robot(simulator, robot)]
    for overlap in simulator.overlaps():
        warnings.append('{}: they overlap at the start, and the physics will throw them apart; '
                        'set {}'.format(overlap, ', '.join(
                            map(option_name, ('x_pos', 'y_pos', 'z_pos')))))
    warnings += add_sensors(simulator, kinds, with_bare)
    return Assembly(simulator, scene_of(simulator), tuple(warnings),
                    (*world.left_out, *problems.names))


def add_sensors(simulator: Simulator, kinds: Sequence[SensorKind], with_bare: bool = False,
                first: int = 0) -> List[str]:
    """Add the sensors of the bodies of a world from the number `first` on; return warnings.

    with_bare: see `build`.
    """
    world, warnings = simulator.world, []
    for tree, body in list(zip(world.file.trees, world.bodies))[first:]:
        if not (kinds and tree.model.tags):
            continue
        try:
            spec = robot_spec.read_model(tree, world.step_s, kinds, with_bare)
            # what has no place belongs to a drive, which only a robot has
            spec = spec._replace(sensors=tuple(each for each in spec.sensors if each.place))
            carrier = Carrier(spec, world, body)
        except SimulationError as error:
            warnings.append('{}; its sensors are not simulated'.format(one_line(error)))
            continue
        warnings += spec.warnings
        if spec.sensors:
            simulator.add_carrier(carrier)
    return warnings


def add_robot(simulator: Simulator, robot: RobotSpec,
              unused_sensors: Sequence[str] = ()) -> List[str]:
    """Load a robot into the world of a simulator; return warnings, a line each.

    Arguments and errors as for `build`; after an error, nothing has changed.
    """
    with _refusal(robot), all_or_nothing(simulator.world.physics_client_id):
        vehicle = Vehicle(robot, simulator.world)
    lines = simulator.add(vehicle)
    unused = [each.name for each in vehicle.sensors if each.kind.name in unused_sensors]
    for sensor in unused:
        vehicle.set_sensor_enabled(sensor, False)
    drive = robot.settings.drive
    lines += wheels.measure(robot.model, drive).warnings(drive, robot.tag_values)
    if not drive.is_there:
        others = [each for each in robot.not_simulated
                  if each.startswith(('plugin', 'controller'))]
        lines.append('it does not drive, as it has no drive that is simulated{}; {}'.format(
            '; it has: {}'.format(shortened(', '.join(others))) if others else '',
            drive_tags.ADVICE))
    return ['{}: {}'.format(robot.source, line) for line in lines] + [
        '{} runs without the sensor {}: no link {}'.format(robot.model.name, sensor, link)
        for sensor, link in vehicle.missing_sensors.items() if sensor not in unused]


def add_robot_apart(simulator: Simulator, robot: RobotSpec) -> List[str]:
    """Add a robot like `add_robot`, but not inside of a wall or another robot.

    Raises SimulationError also when there is no place.
    """
    warnings = add_robot(simulator, robot)
    vehicle = simulator.vehicles[-1]
    try:
        if robot.has_place:
            others = simulator.overlapped(vehicle.robot)
            if others:
                raise SimulationError('it would start inside of {}'.format(', '.join(others)),
                                      'give it another x_pos, y_pos or z_pos')
        else:
            places.start_apart(simulator, vehicle)
    except UserError as error:
        simulator.remove(vehicle)
        raise robot_spec.refused(robot.source, error.problem, error.advice)
    return warnings + _place_of(vehicle, simulator.world)


def _place_of(vehicle: Vehicle, world: World) -> List[str]:
    """Return the warnings about a robot that was lifted, is below a terrain or falls."""
    name, lines = vehicle.robot.name, []
    if vehicle.lift.onto:
        lines.append('{}: at z_pos {:g} m it would be in {}; it was lifted onto it by {:.3f} m'
                     .format(name, vehicle.settings.spawn.z_pos, vehicle.lift.onto,
                             vehicle.lift.height_m))
    below, _ = standing.first_in_line(vehicle.robot, upward=False)
    above, height_m = standing.first_in_line(vehicle.robot, upward=True)
    for body in world.bodies:
        if body.body_id == above and (body.is_terrain or below == -1):
            return [*lines, '{}: it starts below {}, which is at {:.3f} m there; set z_pos'.format(
                name, body.name, height_m)]
    if below == -1:
        lines.append('{}: it falls, as nothing is below it: the world has no ground_plane or '
                     'other floor there'.format(name))
    return lines


@contextlib.contextmanager
def _refusal(robot: RobotSpec) -> Iterator[None]:
    try:
        yield
    except SimulationError as error:
        raise robot_spec.refused(robot.source, error.problem, error.advice)
