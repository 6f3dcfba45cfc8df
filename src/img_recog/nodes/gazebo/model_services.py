"""The topics and services of Gazebo's models, where the package gazebo_msgs is installed."""
from typing import Callable

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3

from img_recog.conversions import robot_msgs
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.simulation.models import WORLD, Models, State
from img_recog.simulation.settings import SimulationError

try:
    from gazebo_msgs.msg import ModelState, ModelStates
    from gazebo_msgs.srv import (GetModelState, GetModelStateRequest, GetModelStateResponse,
                                 SetModelState, SetModelStateRequest, SetModelStateResponse)
    AVAILABLE = True
except ImportError:
    AVAILABLE = False

_WORLD_NAMES = ('', 'world', 'map', '/map')         # gazebo_ros's names for the world frame


class ModelServices:
    """Publishes ~model_states and serves ~get_model_state and ~set_model_state.

    Must be created only when AVAILABLE.
    """

    def __init__(self, models: Models, calls: ServiceCalls, time_s: Callable[[], float]):
        """Advertise; time_s returns the simulated time."""
        self._models, self._calls, self._time_s = models, calls, time_s
        self._states = rospy.Publisher('~model_states', ModelStates, queue_size=10)
        rospy.Service('~get_model_state', GetModelState, self._get)
        rospy.Service('~set_model_state', SetModelState, self._set)

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
        try:
            self._calls.call(lambda: self._models.set_state(
                wanted.model_name, _state_of(wanted), _frame_of(wanted.reference_frame)))
        except SimulationError as error:
            return SetModelStateResponse(success=False, status_message=str(error))
        return SetModelStateResponse(success=True)


def _frame_of(name: str) -> str:
    return WORLD if name in _WORLD_NAMES else name


def _pose_of(state: State) -> Pose:
    return Pose(Point(*state.position), Quaternion(*state.orientation))


def _twist_of(state: State) -> Twist:
    return Twist(Vector3(*state.linear), Vector3(*state.angular))


def _state_of(msg: 'ModelState') -> State:
    position, orientation = msg.pose.position, msg.pose.orientation
    linear, angular = msg.twist.linear, msg.twist.angular
    return State((position.x, position.y, position.z),
                 (orientation.x, orientation.y, orientation.z, orientation.w),
                 (linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z))
