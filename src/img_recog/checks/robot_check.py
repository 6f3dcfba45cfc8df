"""How the robot in a file is simulated: built as in the node, and driven."""
import math
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.checks import looks
from img_recog.checks.check_report import MEASURED, SIMULATED, CheckReport, CheckRow, rows_of
from img_recog.conversions.topic_checks import check_topics
from img_recog.errors import UserError, one_line
from img_recog.formats import drive_controllers
from img_recog.formats.drive_controllers import Controllers
from img_recog.formats.markup import MarkupError, read_bytes
from img_recog.formats.world_file import EMPTY
from img_recog.formats.yaml_text import load_yaml
from img_recog.loading import assemble
from img_recog.report import ASSUMED, NOT_SIMULATED
from img_recog.simulation import wheels
from img_recog.simulation.configured_model import ConfiguredModel, refusals
from img_recog.simulation.simulation_settings import DriveSettings, PhysicsSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.simulated_model import Robot

_LINEAR, _ANGULAR = 0.2, 0.5            # commands in m/s and rad/s
_SECONDS, _COMMAND_PERIOD_S = 2.0, 0.1
# of the command; robots whose wheels slip when they turn do so by a third of theirs
_DRIVES, _SLIPS = 0.9, 0.2
_DRIFT_M = 0.02         # of a robot that turns in place
_TURNING = 'turning'
# rad: along the axes of the world, which the friction has, and between them
_HEADINGS = 0.0, 0.785
_WHEELS = 'see the axes, the shapes and the friction of its wheels'
_LEANS = 0.0001, 0.05   # rad, of an axle that was meant to be level
# units of what is always shown
_OF_WHEELS = {'left_joint': '', 'right_joint': '', 'wheel_separation': ' m',
              'wheel_diameter': ' m', 'wheel_torque': ' N m'}
_UNITS = {'drive': '', 'command_topic': '', **_OF_WHEELS}


def check(path: str, parameters: Sequence[str] = ()) -> CheckReport:
    """Return what is simulated of a robot.

    path: of a URDF or xacro file; parameters: paths of YAML files, those of its controllers.
    Raises a UserError when it cannot be used.
    """
    spec = assemble.robot(path,
                          controllers=lambda namespace: _controllers(namespace, parameters))
    with refusals(path):
        check_topics(spec, [], lambda name: '/' + name.lstrip('/'))
    drive = spec.settings.drive
    simulator = assemble.simulator(PhysicsSettings(world=EMPTY), [spec])
    robot, report = simulator.robots[0], simulator.world.report
    drawn, boxes = looks.read(simulator)
    rows = [*_body(robot, boxes), *_friction(spec), *_drive(spec),
            *_sensors(spec, robot),
            drawn, *rows_of(report)]
    before = report.lines()
    lines: Dict[str, None] = {}
    # a wheel about a wrong axis leaves the floor, which is not its defect
    if not wheels.measure(spec.model, drive).askew:
        report.listen(lambda line: lines.update({'{}: {}'.format(path, line): None}))
    driven = list(_driven(spec, simulator)) if drive.is_there else []
    slips = _slips(drive)
    drifts = [each for each in driven if not each.asked]
    still = [each for each in driven if each.got < each.asked * (
        _SLIPS if slips and each.what == _TURNING else _DRIVES)]
    return CheckReport('robot {} in {}'.format(robot.body.name, path),
                       rows + [each.row() for each in driven],
                       # one that does not touch the floor cannot drive
                       (*before,
                        *(lines or [each.warning(path) for each in still + drifts])),
                       is_partial=bool(report.is_partial or still or not drive.is_there))


def _controllers(namespace: str, paths: Sequence[str]) -> Controllers:
    """Return the controllers in YAML files, as rosparam loads them into the robot's namespace."""
    found: Dict[str, Mapping[str, Any]] = {}
    for path in paths:
        try:
            values = load_yaml(read_bytes(path))
        except (OSError, MarkupError) as error:
            raise UserError('cannot read the parameters in {}: {}'.format(path, one_line(error)),
                            'give the YAML file of its controllers')
        inner = values.get(namespace) if isinstance(values, dict) else None
        for each in (values, inner):
            found.update(drive_controllers.among(each, namespace))
    return found


def _body(robot: Robot, boxes: Sequence[looks.Box]) -> Iterator[CheckRow]:
    body = robot.body
    yield CheckRow(SIMULATED, 'mass', '{:.4g} kg'.format(body.mass()))
    yield CheckRow(SIMULATED, 'size', looks.size(boxes[0]))
    yield CheckRow(SIMULATED, 'root link', body.root)
    yield CheckRow(SIMULATED, 'movable joints', ', '.join(body.joints) or 'none')
    held = [joint.name for joint in body.model.joints if joint.held and joint.name not in (
        *robot.settings.drive.left_joints, *robot.settings.drive.right_joints)]
    if held:
        yield CheckRow(SIMULATED, 'joints that are held', ', '.join(held), 'ros_control')


def _friction(robot: ConfiguredModel) -> Iterator[CheckRow]:
    """Return a row for the links of each coefficient."""
    links = [link for link in robot.model.links if link.solids]
    for state, source in ((SIMULATED, '<mu1>, <mu> or <lateral_friction>'), (ASSUMED, 'default')):
        of_state = [link for link in links if (state == ASSUMED) == all(
            solid.friction is None for solid in link.solids)]
        for value in sorted({link.surface.mu for link in of_state}):
            yield CheckRow(state, 'friction', '{:g} of {}'.format(value, ', '.join(
                link.name for link in of_state if link.surface.mu == value)), source)


def _drive(robot: ConfiguredModel) -> Iterator[CheckRow]:
    drive = robot.settings.drive
    if not drive.is_there:
        yield CheckRow(NOT_SIMULATED, 'drive', 'none')
        return
    measured = wheels.measure(robot.model, drive).values()
    given = robot.tag_values.keys() & vars(drive)
    for name, value in vars(drive).items():
        if name in _OF_WHEELS and not drive.left_joints:
            continue
        text = _text(value) + _UNITS.get(name, '')
        if name in given or (name == 'drive' and given):
            yield CheckRow(SIMULATED, name, text, 'plugin or controller')
        elif measured.get(name) == value:
            yield CheckRow(SIMULATED, name, text, 'shapes of the wheels')
        elif name in _UNITS:
            yield CheckRow(ASSUMED, name, text, 'default')


def _text(value: Any) -> str:
    """Return a value as parameters of ROS have it.

    >>> _text(False), _text(1e6)
    ('false', '1e+06')
    """
    if isinstance(value, bool):
        return str(value).lower()
    return '{:g}'.format(value) if isinstance(value, float) else str(value)


def _sensors(spec: ConfiguredModel, robot: Robot) -> Iterator[CheckRow]:
    for sensor in robot.mounted.published:
        kind, settings = sensor.kind, robot.settings.sensors[sensor.name]
        is_given = sensor.place is not None or bool(spec.tag_values.keys() & vars(settings))
        text = '{} on {}, {:.4g} Hz'.format(getattr(kind.msg_type, '_type'), kind.topic(settings),
                                            1 / getattr(settings, kind.name + '_period_s'))
        yield CheckRow(SIMULATED if is_given else ASSUMED, sensor.name, text,
                       '<gazebo> tag' if is_given else 'default')
    for camera in spec.cameras:
        topics = ', '.join(filter(None, (
            camera.camera_image_topic, camera.camera_depth_topic, camera.camera_points_topic)))
        yield CheckRow(SIMULATED, 'camera on ' + camera.camera_frame,
                       '{}: {}x{}, {:g} Hz, {}'.format(
                           topics, camera.camera_width, camera.camera_height, camera.camera_rate,
                           camera.camera_lens), '<gazebo> tag')


class _Driven(NamedTuple):
    """How fast a robot moved, straight or turning, and how fast it was told to."""

    what: str
    got: float
    asked: float
    unit: str
    advice: str = _WHEELS

    def row(self) -> CheckRow:
        return CheckRow(MEASURED, self.what, '{:.3f} {}'.format(self.got, self.unit),
                        'asked {:g} {}'.format(self.asked, self.unit))

    def warning(self, source: str) -> str:
        return '{}: it does not drive as asked: {} {:.3f} {}, asked {:g}; {}'.format(
            source, self.what, self.got, self.unit, self.asked, self.advice)


def _driven(spec: ConfiguredModel, simulator: Simulator) -> Iterator[_Driven]:
    """Yield how fast the robot moves when it is told to, on the floor alone.

    Also yield how far it moves when it is told to turn in place, if that is far. If wheels slip in
    a turn, that can depend on the heading.
    """
    robot = simulator.robots[0]
    for sensor in spec.sensors:
        robot.mounted.set_enabled(sensor.name, False)
    drive = robot.settings.drive
    linear = min(_LINEAR, drive.max_linear_velocity or _LINEAR)
    angular = min(_ANGULAR, drive.max_angular_velocity or _ANGULAR)
    turn = 0.0, angular
    for what, command, unit, heading in (
            ('straight', (linear, 0.0), 'm/s', 0.0),
            *((_TURNING, turn, 'rad/s', each) for each in _HEADINGS[:1 + _slips(drive)])):
        simulator.reset_world()
        if heading:
            x, y, _ = robot.body.motion().position.tolist()
            robot.move_to(x, y, heading)
        _drive_on(simulator, command)
        start, middle = robot.body.motion(), _middle_of_wheels(robot)
        _drive_on(simulator, command)
        end, moved = robot.body.motion(), _middle_of_wheels(robot) - middle
        way = math.remainder(end.yaw - start.yaw, 2 * math.pi) if command[1] else float(
            (end.position - start.position) @ (math.cos(start.yaw), math.sin(start.yaw), 0.0))
        if not heading:
            yield _Driven(what, way / _SECONDS, sum(command), unit)
        drift = float(np.linalg.norm(moved[:2]))
        if command[1] and drift > _DRIFT_M:
            yield _Driven('moved while turning' + (
                ' at a heading of {:g} rad'.format(heading) if heading else ''),
                drift, 0.0, 'm', _advice(spec, drive))
            return


def _slips(drive: DriveSettings) -> bool:
    """Return whether wheels in line on one side slip when the robot turns."""
    return max(len(drive.left_joints), len(drive.right_joints)) > 1


def _advice(spec: ConfiguredModel, drive: DriveSettings) -> str:
    """Return what to do about a robot that moves while it turns in place."""
    for joint in spec.model.joints:
        if _slips(drive) and joint.name in (*drive.left_joints, *drive.right_joints):
            axle = wheels.pose_in_root(joint, spec.model).rotation @ joint.axis
            lean = math.asin(min(abs(axle[2]), 1.0))
            if _LEANS[0] < lean < _LEANS[1]:
                return ('the axle of {} leans by {:.4f} rad, so one edge of each wheel carries '
                        'the load; if its rpy has 1.57, write 1.5707963').format(joint.name, lean)
    return _WHEELS


def _middle_of_wheels(robot: Robot) -> np.ndarray:
    """Return the middle (3,) of the driven wheels in m, or of the root link if there are none."""
    drive = robot.settings.drive
    links: List[Optional[str]] = [
        joint.child for joint in robot.body.model.joints
        if joint.name in (*drive.left_joints, *drive.right_joints)]
    return np.mean([robot.body.motion(link).position for link in links or [None]], axis=0)


def _drive_on(simulator: Simulator, command: Tuple[float, float]) -> None:
    """Drive for _SECONDS; the command is repeated, since a robot may stop without one."""
    periods = round(_SECONDS / _COMMAND_PERIOD_S)
    for _ in range(periods):
        simulator.robots[0].command(*command)
        simulator.advance(round(_COMMAND_PERIOD_S / simulator.world.step_s))
