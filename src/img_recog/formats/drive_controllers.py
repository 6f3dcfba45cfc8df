"""The drives that are controllers of ros_control, from their parameters: a row each."""
import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional

from img_recog.errors import SimulationError, shortened
from img_recog.formats.gazebo_tags import DriveDescription, Tags, Values, is_of
from img_recog.formats.reader import name_of, text_of
from img_recog.model import PLANAR
from img_recog.report import NOT_SIMULATED, Report
from img_recog.settings import computable, nearest_period

# the parameters of each controller by its name, which begins with its namespace
Controllers = Mapping[str, Mapping[str, Any]]
# Returns them for the namespace in the plugin, without slashes at the ends, '' for that of the
# robot.
FindControllers = Callable[[str], Controllers]
_Joints = Dict[str, ElementTree.Element]        # by name
CONTROL = Tags(('gazebo_ros_control', 'fetch_gazebo_plugin'), ())      # run controllers
_JOINT_STATES = 'joint_state_controller/JointStateController'       # always simulated
_AXES = {'linear': 'linear/x', 'angular': 'angular/z'}
_OF_FETCH = 'l_wheel_joint', 'r_wheel_joint'      # parameters, and their defaults
_NO_LIMIT = 1e6         # N m, of a joint without a limit of its effort


class _Parameters:
    """Reads the parameters of a controller, those in a namespace by `name/name`."""

    def __init__(self, controller: str, values: Mapping[str, Any], step_s: float):
        self.controller, self._values, self._step_s = controller, values, step_s

    def get(self, path: str) -> Any:
        value: Any = self._values
        for name in path.split('/'):
            value = value.get(name) if isinstance(value, Mapping) else None
        return value

    def number(self, path: str, default: float = math.nan) -> float:
        value = self.get(path)
        try:
            number = default if value is None else float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise self._wrong(path, 'a finite number')
        return computable(number)

    def names(self, path: str) -> List[str]:
        value = self.get(path)
        names = value if isinstance(value, list) else [] if value is None else [value]
        if not names or not all(isinstance(name, str) for name in names):
            raise self._wrong(path, 'the name of a joint, or a list of names')
        return names

    def text(self, path: str, default: str) -> str:
        value = self.get(path)
        return value.strip('/') if isinstance(value, str) and value.strip('/') else default

    def flag(self, path: str, default: bool) -> bool:
        value = self.get(path)
        return default if value is None else bool(value)

    def add_period(self, setting: str, values: Dict[str, Any]) -> None:
        """Set the period of `publish_rate`, if there is one."""
        rate_hz = self.number('publish_rate', 0.0)
        if rate_hz > 0:
            values[setting] = nearest_period(rate_hz, self._step_s)

    def _wrong(self, path: str, expected: str) -> SimulationError:
        return SimulationError('parameter {}/{}: got {}, expected {}'.format(
            self.controller, path, shortened(repr(self.get(path))), expected))


def find(robot: ElementTree.Element, find_controllers: FindControllers, step_s: float,
         report: Report) -> Optional[DriveDescription]:
    """Return the drive of a URDF's <robot> by the first controller that drives its joints.

    step_s: of the physics. report: gets the controllers that are not simulated.
    Raises SimulationError naming a parameter that cannot be used.
    """
    joints = {name_of(joint): joint for joint in robot.findall('joint')}
    controllers = of_robot(robot, find_controllers)
    for name, values in controllers.items():
        kind, parameters = TYPES.get(values['type']), _Parameters(name, values, step_s)
        if kind and set(kind.wheels(parameters)) <= set(joints):    # else of another robot
            found = kind.read(parameters, joints)
            if any(parameters.flag(path + '/has_jerk_limits', False) for path in _AXES.values()):
                report.add(NOT_SIMULATED, 'jerk limits of controller ' + name)
            _add_others(report, robot, controllers, name)
            return found
    _add_others(report, robot, controllers)
    return None


def joint_states(robot: ElementTree.Element, find_controllers: FindControllers,
                 step_s: float) -> Values:
    """Return the settings of joint states that a controller of a <robot> publishes."""
    values: Values = {}
    for name, parameters in of_robot(robot, find_controllers).items():
        if parameters['type'] == _JOINT_STATES:
            values.setdefault('joint_states_period_s', step_s)
            _Parameters(name, parameters, step_s).add_period('joint_states_period_s', values)
    return values


def of_robot(robot: ElementTree.Element, find_controllers: FindControllers) -> Controllers:
    """Return the controllers that a robot can have: none without the plugin that runs them."""
    for plugin in robot.findall('gazebo/plugin'):
        if is_of(plugin, CONTROL):
            return find_controllers(text_of(plugin, 'robotNamespace').strip('/'))
    return {}


def held(robot: ElementTree.Element, find_controllers: FindControllers) -> Dict[str, float]:
    """Return the joints of a <robot> that ros_control keeps from moving, as `Joint.held` says it.

    Those are the joints with an interface of positions or velocities while no controller commands
    them, and those with one of efforts of which a controller is known.
    """
    controllers = of_robot(robot, find_controllers)
    joints = {name_of(joint): joint for joint in robot.findall('joint')}
    found: Dict[str, float] = {}
    if not any(is_of(plugin, CONTROL) for plugin in robot.findall('gazebo/plugin')):
        return found
    for transmission in robot.findall('transmission'):
        for joint in transmission.findall('joint'):
            name = name_of(joint)
            kind = (text_of(joint, 'hardwareInterface')
                    or text_of(transmission, 'actuator/hardwareInterface')).split('/')[-1]
            is_named = any(name in _listed(values.get(key)) for values in controllers.values()
                           for key in ('joint', 'joints'))
            if kind == 'PositionJointInterface' or kind == 'EffortJointInterface' and is_named:
                found[name] = math.inf
            elif kind == 'VelocityJointInterface' and name in joints:
                found[name] = _effort(joints[name])
    return found


def _listed(value: Any) -> List[Any]:
    return value if isinstance(value, list) else [value]


def none(_: str) -> Controllers:
    """Return none."""
    return {}


def among(parameters: Any, namespace: str) -> Controllers:
    """Return the controllers among parameters; their names get the namespace before them."""
    return {'/'.join(filter(None, (namespace, name))): value
            for name, value in sorted(parameters.items() if isinstance(parameters, dict) else ())
            if isinstance(value, dict) and '/' in str(value.get('type', ''))}


def _add_others(report: Report, robot: ElementTree.Element, controllers: Controllers,
                drive: str = '') -> None:
    """Add the controllers that are not simulated; drive: the name of the one that is."""
    joints = [name_of(joint) for joint in robot.findall('joint')]
    for name, values in controllers.items():
        if name != drive and values['type'] != _JOINT_STATES:
            kind = None if drive else TYPES.get(values['type'])
            missing = [wheel for wheel in kind.wheels(_Parameters(name, values, 0.0))
                       if wheel not in joints] if kind else []
            report.add(NOT_SIMULATED, 'controller {} ({}{})'.format(
                shortened(name), shortened(values['type']),
                ': the robot has no joint {}'.format(shortened(', '.join(missing)))
                if missing else ''))


def _diff_drive(parameters: _Parameters, joints: _Joints) -> DriveDescription:
    """Read those of diff_drive_controller."""
    left, right = parameters.names('left_wheel'), parameters.names('right_wheel')
    radius = parameters.number('wheel_radius_multiplier', 1.0)
    values: Values = {
        'left_joint': ', '.join(left), 'right_joint': ', '.join(right),
        'wheel_separation_multiplier': parameters.number('wheel_separation_multiplier', 1.0),
        'left_wheel_radius_multiplier': parameters.number('left_wheel_radius_multiplier', radius),
        'right_wheel_radius_multiplier': parameters.number('right_wheel_radius_multiplier',
                                                           radius),
        'wheel_torque': min(_effort(joints[name]) for name in (*left, *right)),
        'wheel_acceleration': 0.0,
        **_common(parameters)}
    if parameters.get('wheel_separation') is not None:
        values['wheel_separation'] = parameters.number('wheel_separation')
    if parameters.get('wheel_radius') is not None:
        values['wheel_diameter'] = 2 * parameters.number('wheel_radius')
    return DriveDescription(CONTROL, values)


def _mecanum(parameters: _Parameters, _: _Joints) -> DriveDescription:
    """Read those of mecanum_drive_controller; the rollers of its wheels are not simulated."""
    return DriveDescription(CONTROL, {'drive': PLANAR, **_common(parameters)})


def _fetch(parameters: _Parameters, joints: _Joints) -> DriveDescription:
    """Read those of robot_controllers, with the defaults in its code, which are of Fetch."""
    left, right = (parameters.text(name, name) for name in _OF_FETCH)
    return DriveDescription(CONTROL, {
        'left_joint': left, 'right_joint': right,
        'wheel_separation': parameters.number('track_width', 0.37476),
        'wheel_diameter': 2 / parameters.number('radians_per_meter', 16.5289),
        'wheel_torque': min(_effort(joints[name]) for name in (left, right)),
        'wheel_acceleration': 0.0,
        'max_linear_velocity': parameters.number('max_velocity_x', 1.0),
        'max_angular_velocity': parameters.number('max_velocity_r', 4.5),
        'max_linear_acceleration': parameters.number('max_acceleration_x', 0.75),
        'max_angular_acceleration': parameters.number('max_acceleration_r', 3.0),
        'cmd_vel_timeout': parameters.number('timeout', 0.25),
        'command_topic': parameters.controller + '/command',
        'odometry_source': 'encoder', 'base_frame': 'base_link',
        'publish_odom_tf': parameters.flag('publish_tf', True)})


class _Kind(NamedTuple):
    """wheels: returns the joints that the parameters name; read: what the drive is."""

    wheels: Callable[[_Parameters], List[str]]
    read: Callable[[_Parameters, _Joints], DriveDescription]


# by the types that the controllers have
TYPES = {
    'diff_drive_controller/DiffDriveController': _Kind(
        lambda parameters: [name for side in ('left_wheel', 'right_wheel')
                            for name in parameters.names(side)], _diff_drive),
    'mecanum_drive_controller/MecanumDriveController': _Kind(
        lambda parameters: [name for corner in ('front_left', 'front_right', 'back_left',
                                                'back_right')
                            for name in parameters.names(corner + '_wheel_joint')], _mecanum),
    'robot_controllers/DiffDriveBaseController': _Kind(
        lambda parameters: [parameters.text(name, name) for name in _OF_FETCH], _fetch)}


def _common(parameters: _Parameters) -> Values:
    values: Values = {
        'odometry_source': 'encoder', 'odometry_period_s': 0.02,
        'base_frame': parameters.text('base_frame_id', 'base_link'),
        'odom_frame': parameters.text('odom_frame_id', 'odom'),
        'publish_odom_tf': parameters.flag('enable_odom_tf', True),
        'cmd_vel_timeout': parameters.number('cmd_vel_timeout', 0.5),
        'command_topic': parameters.controller + '/cmd_vel',
        'odometry_topic': parameters.controller + '/odom',
        'stamped_commands': parameters.flag('use_stamped_vel', False)}
    parameters.add_period('odometry_period_s', values)
    for name, path in _AXES.items():
        for kind in ('velocity', 'acceleration'):
            if parameters.flag('{}/has_{}_limits'.format(path, kind), False):
                for bound in ('max', 'min'):
                    limit = '{}/{}_{}'.format(path, bound, kind)
                    values['{}_{}_{}'.format(bound, name, kind)] = parameters.number(limit, 0.0)
    return values


def _effort(joint: ElementTree.Element) -> float:
    """Return the highest torque of a joint in N m, as gazebo_ros_control has it."""
    limit = joint.find('limit')
    try:
        effort = float('' if limit is None else limit.get('effort', ''))
    except ValueError:
        return _NO_LIMIT
    return min(effort, _NO_LIMIT) if effort > 0 else _NO_LIMIT
