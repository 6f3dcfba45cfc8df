"""The topics and services of Gazebo's models, where the package gazebo_msgs is installed."""
from functools import partial
from typing import Any, Callable

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3

from img_recog import resources, rotations
from img_recog.conversions import robot_msgs
from img_recog.errors import UserError
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.robot_plans import RobotPlans
from img_recog.nodes.gazebo.robots import Robots
from img_recog.simulation.descriptions import model_file, names
from img_recog.simulation.models import WORLD, Models, State
from img_recog.simulation.settings import SimulationError, SpawnSettings

try:
    from gazebo_msgs.msg import ModelStates
    from gazebo_msgs.srv import (DeleteModel, DeleteModelRequest, DeleteModelResponse,
                                 GetModelState, GetModelStateRequest, GetModelStateResponse,
                                 SetModelState, SetModelStateRequest, SetModelStateResponse,
                                 SpawnModel, SpawnModelRequest, SpawnModelResponse)
    AVAILABLE = True
except ImportError:
    AVAILABLE = False

_MAX_TILT = 0.01                                    # rad
_WORLD_NAMES = ('', 'world', 'map', '/map')         # gazebo_ros's names for the world frame


class ModelServices:
    """Publishes ~model_states; serves ~get_model_state, ~set_model_state, ~spawn_sdf_model,
    ~spawn_urdf_model and ~delete_model.

    Must be created only when AVAILABLE.
    """

    def __init__(self, models: Models, robots: Robots, plans: RobotPlans, calls: ServiceCalls,
                 time_s: Callable[[], float]):
        """Advertise; time_s returns the simulated time."""
        self._models, self._robots, self._plans = models, robots, plans
        self._calls, self._time_s = calls, time_s
        self._states = rospy.Publisher('~model_states', ModelStates, queue_size=10)
        rospy.Service('~get_model_state', GetModelState, self._get)
        rospy.Service('~set_model_state', SetModelState, self._set)
        for name in ('~spawn_sdf_model', '~spawn_urdf_model'):
            rospy.Service(name, SpawnModel, self._spawn)
        rospy.Service('~delete_model', DeleteModel, self._delete)

    def update(self) -> None:
        """Publish the states of all models; to be called by the loop."""
        if self._states.get_num_connections():
            msg = ModelStates()
            for name in self._models.names:
                state = self._models.state(name)
                msg.name.append(name)
                msg.pose.append(_pose_of(state))
                msg.twist.append(_twist_of(state))
            self._states.publish(msg)

    def _get(self, request: 'GetModelStateRequest') -> 'GetModelStateResponse':
        frame = _frame_of(request.relative_entity_name)
        try:
            state, time_s = self._calls.call(
                lambda: (self._models.state(request.model_name, frame), self._time_s()))
        except SimulationError as error:
            return GetModelStateResponse(success=False, status_message=str(error))
        response = GetModelStateResponse(pose=_pose_of(state), twist=_twist_of(state),
                                         success=True)
        response.header.stamp = robot_msgs.stamp_of(time_s)
        response.header.frame_id = frame
        return response

    def _set(self, request: 'SetModelStateRequest') -> 'SetModelStateResponse':
        wanted = request.model_state
        return self._answer(SetModelStateResponse, lambda: self._models.set_state(
            wanted.model_name, _state_of(wanted.pose, wanted.twist),
            _frame_of(wanted.reference_frame)))

    def _spawn(self, request: 'SpawnModelRequest') -> 'SpawnModelResponse':
        name, frame = request.model_name.strip(), _frame_of(request.reference_frame)
        state = _state_of(request.initial_pose, Twist())
        try:
            if not name:
                raise SimulationError('model_name is empty', 'give the model a name')
            # read in the thread of the service: the simulation goes on meanwhile
            if model_file.is_robot(request.model_xml):
                add = self._robot_adder(name, request, state, frame)
            else:
                trees = model_file.read(request.model_xml, name, resources.find)
                add = partial(self._models.add, name, trees, state, frame)
        except UserError as error:
            return SpawnModelResponse(success=False, status_message=str(error))
        response = self._answer(SpawnModelResponse, add)
        if response.success:
            rospy.loginfo('added the model %s', name)
        return response

    def _robot_adder(self, name: str, request: 'SpawnModelRequest', state: State,
                     frame: str) -> Callable[[], None]:
        """Return what adds a robot that has a drive: it gets topics in its namespace."""
        names.check('model', name)
        pose = self._calls.call(lambda: self._models.pose_in_world(state, frame))
        x, y, z = pose.translation.tolist()
        roll, pitch, yaw = rotations.to_rpy(pose.rotation).tolist()
        if max(abs(roll), abs(pitch)) > _MAX_TILT:
            raise SimulationError('a robot starts upright: got roll {:.3f} and pitch {:.3f} rad'
                                  .format(roll, pitch), 'tilt it with set_model_state')
        plan = self._plans.spawned(name, request.model_xml, request.robot_namespace.strip('/'),
                                   SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw))
        return partial(self._robots.add, plan)

    def _delete(self, request: 'DeleteModelRequest') -> 'DeleteModelResponse':
        response = self._answer(DeleteModelResponse, partial(self._remove, request.model_name))
        if response.success:
            rospy.loginfo('deleted the model %s', request.model_name)
        return response

    def _remove(self, name: str) -> None:
        vehicle = self._models.vehicle(name)
        if vehicle is None:
            self._models.remove(name)
        else:
            self._robots.remove(vehicle.robot.name)

    def _answer(self, response: Callable[..., Any], action: Callable[[], None]) -> Any:
        """Have the loop call `action`; return the response with its result."""
        try:
            self._calls.call(action)
        except UserError as error:
            return response(success=False, status_message=str(error))
        return response(success=True)


def _frame_of(name: str) -> str:
    return WORLD if name in _WORLD_NAMES else name


def _pose_of(state: State) -> Pose:
    return Pose(Point(*state.position), Quaternion(*state.orientation))


def _twist_of(state: State) -> Twist:
    return Twist(Vector3(*state.linear), Vector3(*state.angular))


def _state_of(pose: Pose, twist: Twist) -> State:
    position, orientation = pose.position, pose.orientation
    linear, angular = twist.linear, twist.angular
    return State((position.x, position.y, position.z),
                 (orientation.x, orientation.y, orientation.z, orientation.w),
                 (linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z))
