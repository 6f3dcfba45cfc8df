"""The one way to build a simulator, in two steps, since a node reads parameters in between.

`read_robot` reads a URDF; `build` makes the simulator from robots, settings and a
world. Both return warnings and log nothing.
"""
import contextlib
import dataclasses
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Iterator, List, Mapping, NamedTuple, Sequence, Tuple, Union

from img_recog import rotations
from img_recog.errors import SimulationError, UserError, one_line, shortened
from img_recog.files import FindFile
from img_recog.formats import (audit, camera_tags, drive_controllers, drive_tags, gazebo_tags,
                               lumping, urdf as urdf_file)
from img_recog.formats.audit import Finding
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.mesh_file import READABLE
from img_recog.model import Model, Tree
from img_recog.settings import SettingError, from_mapping
from img_recog.simulation import places
from img_recog.simulation.carrier import Carrier
from img_recog.simulation.physics import standing, wheels
from img_recog.simulation.physics.client import all_or_nothing, connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.pictures.scene import Scene, scene_of
from img_recog.simulation.sensors import robot_camera
from img_recog.simulation.sensors.sensor import RobotSensor, SensorKind, sensors_of
from img_recog.simulation.settings import (CameraSettings, DriveSettings, NoiseSettings,
                                           PhysicsSettings, RobotSettings, SpawnSettings, names_in)
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

ReadSettings = Callable[[type, Mapping[str, Any]], Any]


class RobotSource(NamedTuple):
    """What a file says of a robot, or of a model with sensors.

    source: what messages call the text, like robot_description or the path of a file; sensors:
    all but cameras; tag_values: the settings in its <gazebo> tags of what is there once and of the
    first sensor of each kind, by name; cameras: those in its tags, and camera_names: of their
    <sensor>s; warnings: a line each; not_simulated: what is in its tags; other_drives: the part of
    that which may drive the robot, where nothing else says how it is driven; findings: what else
    is not done as asked.
    """

    source: str
    model: Model
    sensors: Sequence[RobotSensor]
    tag_values: gazebo_tags.Values
    cameras: Tuple[CameraSettings, ...]
    warnings: Tuple[str, ...]
    not_simulated: Tuple[str, ...] = ()
    other_drives: Tuple[str, ...] = ()
    findings: Tuple[Finding, ...] = ()
    camera_names: Tuple[str, ...] = ()


class Assembly(NamedTuple):
    """A simulator, the scene of which copies can be drawn, and warnings, a line each.

    sources: of each of its carriers, from what it was made; left_out: what PyBullet could not load
    of the world.
    """

    simulator: Simulator
    scene: Scene
    sources: Tuple[RobotSource, ...]
    warnings: Tuple[str, ...]
    left_out: Tuple[str, ...] = ()


def read_robot(urdf: Union[str, ElementTree.Element], step_s: float, find: FindFile, source: str,
               kinds: Sequence[SensorKind] = (),
               controllers: FindControllers = drive_controllers.none) -> RobotSource:
    """Read a URDF.

    urdf: its text, or what was parsed of it. step_s: of the physics. find: returns the path of the
    URI of a mesh or a texture. source: see RobotSource. kinds: of the sensors that it can have.
    controllers: returns those of ros_control that it can have.
    Raises SimulationError naming the source when it is not a URDF that can be simulated.
    """
    try:
        root = urdf_file.root_of(urdf)
        model = lumping.lumped(urdf_file.read(root, find, controllers))
        drive = drive_tags.find(root, step_s, controllers)
        tags, unused = urdf_file.used_tags(root, model)
        found = gazebo_tags.read(tags, step_s, (*([drive.tags] if drive else ()),
                                                *(kind.read_tags for kind in kinds)))
        cameras, of_cameras = camera_tags.read(tags, model.frames)
        camera_settings = tuple(map(robot_camera.settings_of, cameras))
        findings = audit.merged([*audit.audit(root), *(Finding(
            audit.NOT_USED, 'the <gazebo> tag, as there is no such link,', (name,))
            for name in unused)])
    except SimulationError as error:
        raise _refused(source, error.problem, error.advice)
    moving = [joint.name for joint in model.joints]
    stray = ['joint {} of a joint state publisher'.format(name) for name in names_in(
        found.values.get('joint_states_joints', '')) if name not in moving]
    of_tags = tuple(dict.fromkeys((*found.not_simulated, *of_cameras, *stray)))
    of_controllers = drive.problems if drive else drive_controllers.not_simulated(
        root, drive_controllers.of_robot(root, controllers))
    values = drive.settings(found.values) if drive else found.values
    other_drives = () if drive else tuple(
        part for part in (*found.not_simulated, *of_controllers)
        if part.startswith(('plugin', 'controller')))
    return RobotSource(
        source, model, sensors_of(kinds, found.sensors), values, camera_settings,
        (*('{}: {}'.format(source, line)
           for line in _warnings(model, of_tags, of_controllers)),
         *audit.warnings(source, findings)),
        (*of_tags, *of_controllers), other_drives, findings,
        tuple(camera.sensor for camera in cameras))


def read_model(model: Model, step_s: float, kinds: Sequence[SensorKind],
               with_bare: bool = False) -> RobotSource:
    """Return what an SDF says of a robot, or of a model with sensors.

    with_bare: whether sensors without a plugin are simulated, too.
    Raises SimulationError when a value cannot be used.
    """
    drive, source = drive_tags.of_model(model), 'model ' + model.name
    try:
        found = gazebo_tags.read(model.tags, step_s, (
            *([drive.tags] if drive else ()), *(kind.read_tags for kind in kinds)), with_bare)
        cameras, of_cameras = camera_tags.read(model.tags, model.frames, with_bare)
        settings = tuple(map(robot_camera.settings_of, cameras))
    except SimulationError as error:
        raise _refused(source, error.problem, error.advice)
    of_model = ['plugin ' + plugin.get('filename', '') for tag in model.tags if not tag.link
                for plugin in tag.element.findall('plugin')]        # the audit names them
    not_simulated = tuple(part for part in dict.fromkeys((*found.not_simulated, *of_cameras))
                          if part not in of_model)
    # what has a place is in a tag; the rest belongs to a drive
    sensors = [each for each in sensors_of(kinds, found.sensors)
               if each.place is not None or drive and not each.kind.tags.frame]
    return RobotSource(
        source, model, sensors, drive.settings(found.values) if drive else found.values, settings,
        tuple('not simulated, of {}: {}'.format(source, part) for part in not_simulated),
        not_simulated, camera_names=tuple(camera.sensor for camera in cameras))


def settings_of_model(robot: RobotSource, read: ReadSettings, tree: Tree) -> RobotSettings:
    """Return the settings of a robot of an SDF, which starts where the tree is."""
    x, y, z = tree.pose.translation.tolist()
    yaw = rotations.to_rpy(tree.pose.rotation).tolist()[2]
    settings = settings_of(robot, read)
    return dataclasses.replace(settings, noise=settings.noise.of(tree.name), spawn=SpawnSettings(
        x_pos=x, y_pos=y, z_pos=z, yaw=yaw))


def _warnings(model: Model, of_tags: Sequence[str],
              of_controllers: Sequence[str]) -> Iterator[str]:
    """Yield a line for each thing of a robot that is not done as its file says."""
    yield from model.warnings
    if model.missing_meshes:
        yield ('mesh{} not found, replaced by other shapes of the link: {}; PyBullet reads {} '
               'files; for package:// the package must be built and sourced'.format(
                   '' if len(model.missing_meshes) == 1 else 'es',
                   ', '.join(model.missing_meshes), ', '.join(READABLE)))
    if model.missing_looks:
        yield ('not known or not found, of its materials: {}; those links keep their other color'
               .format(', '.join(model.missing_looks)))
    for name, parts in (('<gazebo> tags', of_tags), ('controllers', of_controllers)):
        if parts:
            yield 'not simulated, of its {}: {}'.format(name, ', '.join(parts))


def settings_of(robot: RobotSource, read: ReadSettings) -> RobotSettings:
    """Return the settings of a robot.

    read: read(settings class, values) returns the settings that the user gives, else those in
    `values`, by name: those of tags, and as the URDF has them, the separation and the diameter of
    the wheels.
    """
    measured = wheels.measure(robot.model, read(DriveSettings, robot.tag_values))
    values: Mapping[str, Any] = {**measured.values(), **robot.tag_values}
    drive = read(DriveSettings, values)
    if robot.other_drives and measured.wheel_separation is None and drive.left_joints:
        raise _refused(robot.source, 'no drive that is simulated; it has: {}'.format(
            shortened(', '.join(robot.other_drives))), drive_tags.ADVICE)
    if measured.swapped:
        # libgazebo_ros_diff_drive has <legacyMode>, in which they are
        drive = dataclasses.replace(drive, left_joint=drive.right_joint,
                                    right_joint=drive.left_joint)
    return RobotSettings(
        read(SpawnSettings, values), drive, read(NoiseSettings, values),
        {each.name: read(each.kind.settings, values) if each.reads_parameters
         else _settings_in_tag(robot.source, each) for each in robot.sensors})


def _settings_in_tag(source: str, sensor: RobotSensor) -> Any:
    try:
        return from_mapping(sensor.kind.settings, sensor.values)
    except SettingError as error:
        raise _refused(source, 'its sensor {}: {}'.format(sensor.name, error.problem),
                       error.advice)


def default_settings(robot: RobotSource) -> RobotSettings:
    """Return the settings of a robot that its URDF and the defaults give.

    Raises SimulationError naming the source when the value of a tag is not allowed.
    """
    try:
        return settings_of(robot, from_mapping)
    except SettingError as error:
        raise _refused(robot.source, error.problem, error.advice)


def build(physics: PhysicsSettings, world: WorldFile,
          robots: Sequence[Tuple[RobotSource, RobotSettings]],
          unused_sensors: Sequence[str] = (),
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
              if with_drives and drive_tags.of_model(tree.model)}
    world = world._replace(trees=tuple(tree for number, tree in enumerate(world.trees)
                                       if number not in driven))
    problems, name = Problems(), 'world {}'.format(world.name)
    simulated_world = World(physics, world, physics_client_id, problems)
    if not physics.allow_partial_world:
        problems.refuse(name, 'set {} to load the rest'.format(option_name('allow_partial_world')))
    warnings = [*world.warnings, *problems.warnings(name), *(
        '{}: model {}'.format(name, line) for line in simulated_world.warnings)]
    if simulated_world.crowded:
        warnings.append('{}: {}'.format(name, simulated_world.crowded))
    if simulated_world.lifted:
        warnings.append('world {}: at the start in the floor, and lifted onto it: {}'.format(
            world.name, ', '.join('{} by {:.3f} m'.format(*each)
                                  for each in simulated_world.lifted.items())))
    simulator = Simulator(simulated_world)
    for robot, settings in robots:
        warnings += add_robot(simulator, robot, settings, unused_sensors)
        warnings += _place_of(simulator.vehicles[-1], simulated_world)
    sources = [robot for robot, _ in robots]
    for tree in driven.values():
        robot = read_model(tree.model, physics.step_s, kinds, with_bare)
        warnings += [*robot.warnings, *add_robot(
            simulator, robot, settings_of_model(robot, from_mapping, tree))]
        sources.append(robot)
    for overlap in simulator.overlaps():
        warnings.append('{}: they overlap at the start, and the physics will throw them apart; '
                        'set {}'.format(overlap, ', '.join(
                            map(option_name, ('x_pos', 'y_pos', 'z_pos')))))
    carried, lines = add_sensors(simulator, kinds, with_bare)
    return Assembly(simulator, scene_of(simulator), (*sources, *carried), (*warnings, *lines),
                    problems.names)


def add_sensors(simulator: Simulator, kinds: Sequence[SensorKind], with_bare: bool = False,
                first: int = 0) -> Tuple[List[RobotSource], List[str]]:
    """Add the sensors of the bodies of a world from the number `first` on.

    Returns from what the new carriers are made, and warnings. with_bare: see `build`.
    """
    world, found, warnings = simulator.world, [], []
    for tree, body in list(zip(world.file.trees, world.bodies))[first:]:
        if not (kinds and tree.model.tags):
            continue
        try:
            source = read_model(tree.model, world.step_s, kinds, with_bare)
            settings = RobotSettings(noise=NoiseSettings().of(tree.name), sensors={
                each.name: _settings_in_tag(source.source, each) for each in source.sensors})
            carrier = Carrier(settings, world, body, source.sensors)
        except SimulationError as error:
            warnings.append('{}; its sensors are not simulated'.format(one_line(error)))
            continue
        warnings += source.warnings
        if source.sensors or source.cameras:
            simulator.add_carrier(carrier)
            found.append(source)
    return found, warnings


def add_robot(simulator: Simulator, robot: RobotSource, settings: RobotSettings,
              unused_sensors: Sequence[str] = ()) -> List[str]:
    """Load a robot into the world of a simulator; return warnings, a line each.

    Arguments and errors as for `build`; after an error, nothing has changed.
    """
    with _refusal(robot), all_or_nothing(simulator.world.physics_client_id):
        vehicle = Vehicle(robot.model, settings, simulator.world, robot.sensors)
    lines = simulator.add(vehicle)
    unused = [each.name for each in vehicle.sensors if each.kind.name in unused_sensors]
    for sensor in unused:
        vehicle.set_sensor_enabled(sensor, False)
    lines += wheels.measure(robot.model, settings.drive).warnings(
        settings.drive, robot.tag_values)
    return ['{}: {}'.format(robot.source, line) for line in lines] + [
        '{} runs without the sensor {}: no link {}'.format(robot.model.name, sensor, link)
        for sensor, link in vehicle.missing_sensors.items() if sensor not in unused]


def add_robot_apart(simulator: Simulator, robot: RobotSource, settings: RobotSettings,
                    has_place: bool) -> List[str]:
    """Add a robot like `add_robot`, but not inside of a wall or another robot.

    has_place: whether it starts where its settings say; else that is where the nearest free place
    is searched. Raises SimulationError also when there is none.
    """
    warnings = add_robot(simulator, robot, settings)
    vehicle = simulator.vehicles[-1]
    try:
        if has_place:
            others = simulator.overlapped(vehicle.robot)
            if others:
                raise SimulationError('it would start inside of {}'.format(', '.join(others)),
                                      'give it another x_pos, y_pos or z_pos')
        else:
            places.start_apart(simulator, vehicle)
    except UserError as error:
        simulator.remove(vehicle)
        raise _refused(robot.source, error.problem, error.advice)
    return warnings + _place_of(vehicle, simulator.world)


def named(robot: RobotSource, name: str) -> RobotSource:
    """Return the robot with another name."""
    return robot._replace(model=dataclasses.replace(robot.model, name=name))


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
def _refusal(robot: RobotSource) -> Iterator[None]:
    try:
        yield
    except SimulationError as error:
        raise _refused(robot.source, error.problem, error.advice)


def _refused(source: str, problem: str, advice: str) -> SimulationError:
    return SimulationError('cannot use the robot in {}: {}'.format(source, problem), advice)
