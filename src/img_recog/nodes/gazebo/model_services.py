"""The topics and services of Gazebo's models, links and joints.

MISSING says why the package gazebo_msgs cannot be used, '' if it can.
"""
import math
from functools import partial
from typing import Any, Callable, Dict, Iterable, Sequence, Tuple

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3
from std_msgs.msg import Header

from img_recog import rotations
from img_recog.conversions import robot_msgs
from img_recog.errors import SimulationError, UserError, one_line
from img_recog.formats import allowed_names, drive_tags, model_file
from img_recog.loading import resources
from img_recog.model import NO_INERTIA, Tree
from img_recog.nodes.gazebo.model_topics import WorldTopics
from img_recog.nodes.gazebo.physics_services import RuntimeSettings, ServiceCalls
from img_recog.nodes.gazebo.robot_reader import RobotReader
from img_recog.nodes.gazebo.time_gate import TimeGate
from img_recog.report import Report
from img_recog.ros.throttle import ThrottledWarning
from img_recog.rotations import Transform
from img_recog.simulation.models import LINK_SEPARATOR, WORLD, Models, State, check, in_world
from img_recog.simulation.pacing import Pace
from img_recog.simulation.simulation_settings import SpawnSettings
from img_recog.simulation.simulator import Simulator

try:
    from gazebo_msgs.msg import LinkState, LinkStates, ModelState, ModelStates
    from gazebo_msgs.srv import (ApplyBodyWrench, ApplyJointEffort, BodyRequest, DeleteModel,
                                 GetJointProperties, GetLinkProperties, GetLinkState,
                                 GetModelProperties, GetModelState, GetPhysicsProperties,
                                 GetWorldProperties, JointRequest, SetLinkState,
                                 SetModelConfiguration, SetModelState, SetPhysicsProperties,
                                 SpawnModel)
    MISSING = ''
except ImportError as error:
    MISSING = 'gazebo_msgs cannot be loaded: {}'.format(one_line(error))

_MAX_TILT = 0.01                                    # rad
_WORLD_NAMES = ('', 'world', 'map', '/map')         # gazebo_ros's names for the world frame


Response = Dict[str, Any]       # fields of a response by name; rospy makes the message


class ModelServices:
    """Publishes ~model_states and ~link_states, and serves what the constructor names.

    Like gazebo_ros, it takes the states to set on topics, too; a line of the log says why one is
    refused.

    Must be created only when nothing is MISSING.
    """

    def __init__(self, simulator: Simulator, models: Models, topics: WorldTopics,
                 reader: RobotReader, calls: ServiceCalls, pace: Pace, gate: TimeGate,
                 set_factor: Callable[[float], Any]):
        """Advertise. set_factor: sets the real time factor."""
        self._set_factor = set_factor
        self._simulator, self._models, self._topics = simulator, models, topics
        self._reader, self._calls, self._pace, self._gate = reader, calls, pace, gate
        self._step_s = simulator.world.step_s
        self._model_states = rospy.Publisher('~model_states', ModelStates, queue_size=10)
        self._link_states = rospy.Publisher('~link_states', LinkStates, queue_size=10)
        self._warn = ThrottledWarning()
        in_loop = {
            'get_model_state': (GetModelState, self._get),
            'set_model_state': (
                SetModelState, lambda request: self._set_model(request.model_state)),
            'set_link_state': (SetLinkState, lambda request: self._set_link(request.link_state)),
            'delete_model': (DeleteModel, self._delete),
            'get_world_properties': (GetWorldProperties, self._describe_world),
            'get_physics_properties': (GetPhysicsProperties, self._describe_physics),
            'get_link_state': (GetLinkState, self._get_link),
            'get_link_properties': (GetLinkProperties, self._describe_link),
            'get_joint_properties': (GetJointProperties, self._describe_joint),
            'get_model_properties': (GetModelProperties, self._describe_model),
            'set_model_configuration': (SetModelConfiguration, self._set_joints),
            'apply_body_wrench': (ApplyBodyWrench, self._apply_wrench),
            'apply_joint_effort': (ApplyJointEffort, self._apply_effort)}
        for name, (kind, handler) in in_loop.items():
            rospy.Service('~' + name, kind, partial(_respond, partial(self._call, handler)))
        for name, kind, handler in (('spawn_sdf_model', SpawnModel, self._spawn),
                                    ('spawn_urdf_model', SpawnModel, self._spawn),
                                    ('set_physics_properties', SetPhysicsProperties,
                                     self._set_physics)):
            rospy.Service('~' + name, kind, partial(_respond, handler))
        # their responses are empty
        for name, kind, field, clear in (
                ('clear_body_wrenches', BodyRequest, 'body_name', self._models.clear_wrenches),
                ('clear_joint_forces', JointRequest, 'joint_name', self._models.clear_efforts)):
            rospy.Service('~' + name, kind, partial(self._call, partial(_clear, clear, field)))
        for name, kind, set_state in (('set_model_state', ModelState, self._set_model),
                                      ('set_link_state', LinkState, self._set_link)):
            rospy.Subscriber('~' + name, kind, partial(self._take, name, set_state),
                             queue_size=10, tcp_nodelay=True)

    def update(self) -> None:
        """Publish the states of all models and links; to be called by the loop."""
        if self._model_states.get_num_connections():
            self._model_states.publish(_with_states(ModelStates(), (
                (name, self._models.state(name)) for name in self._models.names)))
        if self._link_states.get_num_connections():
            self._link_states.publish(_with_states(LinkStates(), (
                (model + LINK_SEPARATOR + link, in_world(body.motion(link)))
                for model, body in self._models.bodies for link in body.link_names)))

    def _call(self, handler: Callable[[Any], Any], request: Any) -> Any:
        return self._calls.call(partial(handler, request))

    def _get(self, request: Any) -> Response:
        frame = _frame_of(request.relative_entity_name)
        state = self._models.state(request.model_name, frame)
        stamp = robot_msgs.stamp_of(self._simulator.time_s)
        return {'header': Header(stamp=stamp, frame_id=frame), 'pose': _pose_of(state),
                'twist': _twist_of(state)}

    def _take(self, name: str, set_state: Callable[[Any], Response], msg: Any) -> None:
        try:
            self._call(set_state, msg)
        except UserError as error:
            self._warn('ignored a message on %s: %s', rospy.resolve_name('~' + name), error)

    def _set_model(self, wanted: Any) -> Response:
        return self._set(wanted.model_name, wanted)

    def _set_link(self, wanted: Any) -> Response:
        if LINK_SEPARATOR not in wanted.link_name:
            raise SimulationError('link_name: got {!r}, expected MODEL{}LINK'.format(
                wanted.link_name, LINK_SEPARATOR))
        return self._set(wanted.link_name, wanted)

    def _set(self, name: str, wanted: Any) -> Response:
        self._models.set_state(name, _state_of(wanted.pose, wanted.twist),
                               _frame_of(wanted.reference_frame))
        return {}

    def _spawn(self, request: Any) -> Response:
        name, frame = request.model_name, _frame_of(request.reference_frame)
        namespace = request.robot_namespace.strip('/')
        state = _state_of(request.initial_pose, Twist())

        def pose() -> Transform:
            return self._calls.call(lambda: self._models.pose_in_world(state, frame))
        # read in the thread of the service: the simulation goes on meanwhile
        if self._reader.is_robot(request.model_xml, namespace):
            allowed_names.check_model(name)
            add = partial(self._topics.add, self._reader.spawned(
                name, request.model_xml, namespace, _start(pose())))
        else:
            report = Report()
            trees = model_file.read(request.model_xml, name, resources.find, report)
            for line in report.lines():
                rospy.logwarn('%s', line)
            if drive_tags.is_driven(trees[0].model):
                tree = trees[0]._replace(pose=pose() @ trees[0].pose)
                _start(tree.pose)       # refuses what is not upright
                add = partial(self._topics.add, self._reader.spawned_sdf(tree, namespace))
            else:
                add = partial(self._add, name, trees, state, frame)
        self._calls.call(add)
        rospy.loginfo('added the model %s', name)
        return {}

    def _add(self, name: str, trees: Sequence[Tree], state: State, frame: str) -> None:
        self._topics.add_sensors(self._models.add(name, trees, state, frame))

    def _delete(self, request: Any) -> Response:
        self._topics.remove(request.model_name)
        rospy.loginfo('deleted the model %s', request.model_name)
        return {}

    def _describe_world(self, _: Any) -> Response:
        return {'sim_time': self._simulator.time_s, 'model_names': self._models.names,
                'rendering_enabled': True}

    def _describe_physics(self, _: Any) -> Response:
        return {'time_step': self._step_s, 'pause': self._gate.is_paused,
                'max_update_rate': self._pace.wanted / self._step_s,
                'gravity': Vector3(*self._simulator.world.file.gravity),
                'status_message': 'simulated by PyBullet: ode_config is not used'}

    def _set_physics(self, request: Any) -> Response:
        gravity = _vector_of(request.gravity)
        if not math.isclose(request.time_step, self._step_s, rel_tol=1e-6):
            raise SimulationError(
                'time_step: got {:g}, and a simulation that runs keeps its {:g} s'.format(
                    request.time_step, self._step_s), 'set the parameter ~step_s before the start')
        check('gravity', gravity)
        factor = request.max_update_rate * self._step_s
        RuntimeSettings(real_time_factor=factor)        # refuses what is not allowed
        self._set_factor(factor)
        self._call(self._simulator.world.set_gravity, gravity)
        return {'status_message': 'ode_config is not used'}

    def _get_link(self, request: Any) -> Response:
        self._models.link(request.link_name)
        state = self._models.state(request.link_name, _frame_of(request.reference_frame))
        return {'link_state': LinkState(request.link_name, _pose_of(state), _twist_of(state),
                                        request.reference_frame)}

    def _describe_link(self, request: Any) -> Response:
        body, name = self._models.link(request.link_name)
        link = next(each for each in body.model.links if each.name == name)
        inertia = link.inertia or NO_INERTIA
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertia.matrix.tolist()
        # like in Gazebo, which does not say how the axes of the inertia are turned
        return {'com': Pose(Point(*inertia.pose.translation.tolist()), Quaternion(0, 0, 0, 1)),
                'gravity_mode': inertia.mass > 0 and link.has_gravity is not False,
                'mass': inertia.mass, 'ixx': ixx, 'ixy': ixy, 'ixz': ixz, 'iyy': iyy, 'iyz': iyz,
                'izz': izz}

    def _describe_joint(self, request: Any) -> Response:
        body, joint = self._models.joint(request.joint_name)
        position, rate = body.joint_state(body.first_axes[joint])
        # like gazebo_ros, with the type 0 whatever it is, and without damping
        return {'position': [position], 'rate': [rate]}

    def _describe_model(self, request: Any) -> Response:
        bodies = self._models.model(request.model_name).bodies
        joints = [name for body in bodies for name in (*body.model.held, *body.first_axes)]
        return {'body_names': [link for body in bodies for link in body.link_names],
                'joint_names': joints,
                'is_static': not joints and all(body.fixed for body in bodies)}

    def _set_joints(self, request: Any) -> Response:
        names, positions = request.joint_names, request.joint_positions
        if len(names) != len(positions):
            raise SimulationError('got {} joint_names and {} joint_positions'.format(
                len(names), len(positions)), 'give a position for each joint')
        self._models.set_joints(request.model_name, dict(zip(names, positions)))
        return {}

    def _apply_wrench(self, request: Any) -> Response:
        wrench = request.wrench
        self._models.apply_wrench(
            request.body_name, _vector_of(wrench.force), _vector_of(wrench.torque),
            request.start_time.to_sec(), request.duration.to_sec(),
            _vector_of(request.reference_point), _frame_of(request.reference_frame))
        return self._lasting(request)

    def _apply_effort(self, request: Any) -> Response:
        self._models.apply_effort(request.joint_name, request.effort,
                                  request.start_time.to_sec(), request.duration.to_sec())
        return self._lasting(request)

    def _lasting(self, request: Any) -> Response:
        is_short = 0 < request.duration.to_sec() < self._step_s
        return {'status_message': 'duration: a step of {:g} s is the least'.format(
            self._step_s) if is_short else ''}


def _clear(clear: Callable[[str], None], field: str, request: Any) -> Response:
    clear(getattr(request, field))
    return {}


def _start(pose: Transform) -> SpawnSettings:
    """Return where a robot starts; SimulationError when that is not upright."""
    x, y, z = pose.translation.tolist()
    roll, pitch, yaw = rotations.to_rpy(pose.rotation).tolist()
    if max(abs(roll), abs(pitch)) > _MAX_TILT:
        raise SimulationError('a robot starts upright: got roll {:.3f} and pitch {:.3f} rad'
                              .format(roll, pitch), 'tilt it with set_model_state')
    return SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw)


def _respond(handler: Callable[[Any], Response], request: Any) -> Response:
    """Return what a service responds, also when its handler raises a UserError."""
    try:
        return {'success': True, **handler(request)}
    except UserError as error:
        return {'success': False, 'status_message': str(error)}


def _frame_of(name: str) -> str:
    """Return the name that Models has for a reference frame of a request."""
    return WORLD if name in _WORLD_NAMES else name


def _vector_of(msg: Any) -> Tuple[float, float, float]:
    """Return the coordinates of a Vector3 or Point."""
    return msg.x, msg.y, msg.z


def _with_states(msg: Any, states: Iterable[Tuple[str, State]]) -> Any:
    """Return a message of states, with those of some names."""
    for name, state in states:
        msg.name.append(name)
        msg.pose.append(_pose_of(state))
        msg.twist.append(_twist_of(state))
    return msg


def _pose_of(state: State) -> Pose:
    """Return the pose of a state."""
    return Pose(Point(*state.position), Quaternion(*state.orientation))


def _twist_of(state: State) -> Twist:
    """Return the velocities of a state."""
    return Twist(Vector3(*state.linear), Vector3(*state.angular))


def _state_of(pose: Pose, twist: Twist) -> State:
    turn = pose.orientation
    return State(_vector_of(pose.position), (turn.x, turn.y, turn.z, turn.w),
                 _vector_of(twist.linear), _vector_of(twist.angular))
