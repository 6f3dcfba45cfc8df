"""The one way to build a simulator: of robots, their settings and a world.

loading/assemble.py reads the files for it. Warnings are returned; nothing is logged.
"""
import contextlib
from typing import Callable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from img_recog.errors import SimulationError, UserError, one_line, shortened
from img_recog.formats import drive_tags
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.model import Tree
from img_recog.simulation import configured_model, places, wheels
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.mounted_sensors import MountedSensors
from img_recog.simulation.physics import standing
from img_recog.simulation.physics.client import all_or_nothing, connect
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.robot import check_motors
from img_recog.simulation.physics.world import World
from img_recog.simulation.pictures.scene import Scene, scene_of
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulation_settings import PhysicsSettings, whole_steps
from img_recog.simulation.simulated_model import Robot, SimulatedModel
from img_recog.simulation.simulator import Simulator


class Assembly(NamedTuple):
    """What was built, and what of it is not as the files ask.

    Attributes:
        simulator: Simulator.
        scene: Scene of which copies can be drawn.
        warnings: Lines for the user.
        left_out: What of the world could not be read or loaded.
        not_simulated: Drives and sensors of models of the world that are not simulated, each as a
            few words.
    """

    simulator: Simulator
    scene: Scene
    warnings: Tuple[str, ...]
    left_out: Tuple[str, ...] = ()
    not_simulated: Tuple[str, ...] = ()

    @property
    def is_partial(self) -> bool:
        """Whether something that a file asks for is not done."""
        file = self.simulator.world.file
        return bool(self.left_out or self.not_simulated or file.findings or file.missing_looks
                    or any(robot.not_done for robot in self.simulator.robots))


def build(physics: PhysicsSettings, world: WorldFile,
          robots: Sequence[ConfiguredModel], unused_sensors: Sequence[str] = (),
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
    simulated_world = World(physics, world, physics_client_id, problems, SimulatedModel)
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
        warnings += _place_of(simulator.robots[-1], simulated_world)
    not_simulated: List[str] = []
    for tree in driven.values():
        warnings += _add_driven(simulator, tree, kinds, with_bare)
    for overlap in simulator.overlaps():
        warnings.append('{}: they overlap at the start, and the physics will throw them apart; '
                        'set {}'.format(overlap, ', '.join(
                            map(option_name, ('x_pos', 'y_pos', 'z_pos')))))
    for model in simulator.models:
        warnings += add_sensors(simulated_world, model, kinds, with_bare, not_simulated)
    return Assembly(simulator, scene_of(simulator), tuple(warnings),
                    (*world.left_out, *problems.names), tuple(not_simulated))


def _add_driven(simulator: Simulator, tree: Tree, kinds: Sequence[SensorKind],
                with_bare: bool) -> List[str]:
    """Add a model of the world as a robot; return warnings, a line each.

    If its drive or a sensor cannot be used, the model is added as it is, and `add_sensors` finds
    the reason.
    """
    try:
        spec = configured_model.from_sdf(tree, simulator.world.step_s, kinds, with_bare)
        return [*spec.warnings, *add_robot(simulator, spec)]
    except SimulationError:
        simulator.world.load([tree])
        return []


def add_sensors(world: World, model: SimulatedModel, kinds: Sequence[SensorKind],
                with_bare: bool = False,
                not_simulated: Optional[List[str]] = None) -> List[str]:
    """Add the sensors that the file of a model of the world has; a robot has them already.

    Args:
        world: World of the model.
        model: Model.
        kinds: Kinds of sensors; none for models without sensors.
        with_bare: Whether sensors without a plugin are simulated, too.
        not_simulated: Gets what is not simulated of the drive and the sensors.

    Returns:
        Warnings, a line each.
    """
    warnings: List[str] = []
    not_simulated = [] if not_simulated is None else not_simulated
    for tree, body in zip(model.trees, model.bodies):
        if model.is_robot or not (kinds and tree.model.tags):
            continue
        try:
            spec = configured_model.from_sdf(tree, world.step_s, kinds, with_bare)
            _check_drive(spec, world.step_s, body)
            # what has no place belongs to a drive, which only a robot has
            spec = spec._replace(sensors=tuple(each for each in spec.sensors if each.place))
            mounted = MountedSensors(spec, world, body)
        except SimulationError as error:
            warnings.append('{}; its sensors {}are not simulated'.format(
                one_line(error), 'and its drive ' * drive_tags.is_driven(tree.model)))
            not_simulated.append('sensors of model ' + tree.name)
            continue
        warnings += spec.warnings
        not_simulated += ['{} of model {}'.format(part, tree.name) for part in spec.not_simulated]
        if spec.sensors:
            model.sensors.append(mounted)
    return warnings


def _check_drive(spec: ConfiguredModel, step_s: float, body: FramedBody) -> None:
    """Raise SimulationError if a model could not drive as its file says."""
    drive = spec.settings.drive
    if drive.is_there:
        whole_steps('drive_period_s', drive.drive_period_s, step_s)
        with _refusal(spec):
            check_motors(spec.new_drive().motors, body)


def add_robot(simulator: Simulator, spec: ConfiguredModel,
              unused_sensors: Sequence[str] = ()) -> List[str]:
    """Load a robot into the world of a simulator; return warnings, a line each.

    Arguments and errors as for `build`; after an error, nothing has changed.
    """
    with _refusal(spec), all_or_nothing(simulator.world.physics_client_id):
        robot = Robot(spec, simulator.world)
    simulator.world.add([robot])
    lines = list(simulator.world.warnings)
    unused = [each.name for each in spec.sensors if each.kind.name in unused_sensors]
    for sensor in unused:
        robot.set_sensor_enabled(sensor, False)
    drive = spec.settings.drive
    lines += wheels.measure(spec.model, drive).warnings(drive, spec.tag_values)
    if not drive.is_there:
        others = [each for each in spec.not_simulated
                  if each.startswith(('plugin', 'controller'))]
        lines.append('it does not drive, as it has no drive that is simulated{}; {}'.format(
            '; it has: {}'.format(shortened(', '.join(others))) if others else '',
            drive_tags.ADVICE))
    return ['{}: {}'.format(spec.source, line) for line in lines] + [
        '{} runs without the sensor {}: no link {}'.format(spec.model.name, sensor, link)
        for sensor, link in robot.missing_sensors.items() if sensor not in unused]


def add_robot_apart(simulator: Simulator, spec: ConfiguredModel) -> List[str]:
    """Add a robot like `add_robot`, but not inside of a wall or another robot.

    Raises SimulationError also when there is no place.
    """
    warnings = add_robot(simulator, spec)
    robot = simulator.robots[-1]
    try:
        if spec.has_place:
            others = simulator.overlapped(robot.body)
            if others:
                raise SimulationError('it would start inside of {}'.format(', '.join(others)),
                                      'give it another x_pos, y_pos or z_pos')
        else:
            places.start_apart(simulator, robot)
    except UserError as error:
        simulator.world.remove(robot)
        raise configured_model.refused(spec.source, error.problem, error.advice)
    return warnings + _place_of(robot, simulator.world)


def _place_of(robot: Robot, world: World) -> List[str]:
    """Return the warnings about a robot that was lifted, is below a terrain or falls."""
    name, lines = robot.body.name, []
    if robot.lift.onto:
        lines.append('{}: at z_pos {:g} m it would be in {}; it was lifted onto it by {:.3f} m'
                     .format(name, robot.settings.spawn.z_pos, robot.lift.onto,
                             robot.lift.height_m))
    below, _ = standing.first_in_line(robot.body, upward=False)
    above, height_m = standing.first_in_line(robot.body, upward=True)
    for body in world.scenery:
        if body.body_id == above and (body.is_terrain or below == -1):
            return [*lines, '{}: it starts below {}, which is at {:.3f} m there; set z_pos'.format(
                name, body.name, height_m)]
    if below == -1:
        lines.append('{}: it falls, as nothing is below it: the world has no ground_plane or '
                     'other floor there'.format(name))
    return lines


@contextlib.contextmanager
def _refusal(spec: ConfiguredModel) -> Iterator[None]:
    try:
        yield
    except SimulationError as error:
        raise configured_model.refused(spec.source, error.problem, error.advice)
