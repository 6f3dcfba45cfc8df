"""What other nodes ask of Gazebo by gazebo_msgs, where that message package is installed."""
from concurrent.futures import TimeoutError as LateError

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3

from img_recog.conversions import robot_msgs
from img_recog.ros.queues import CallQueue
from img_recog.simulation.models import WORLD, Models, State
from img_recog.simulation.settings import SimulationError

try:
    from gazebo_msgs.msg import ModelStates
    from gazebo_msgs.srv import (GetModelState, GetModelStateResponse, SetModelState,
                                 SetModelStateResponse)
    AVAILABLE = True
except ImportError:
    AVAILABLE = False

_TIMEOUT_S = 5.0
_WORLD_NAMES = ('', 'world', 'map', '/map')         # for the same frame, in gazebo_ros


class GazeboInterface:
    """Publishes ~model_states and serves ~get_model_state and ~set_model_state.

    To be made only where AVAILABLE. `requests` are done by the loop that steps the simulation.
    """

    def __init__(self, models: Models, requests: CallQueue, time_s):
        """Advertise; time_s() is the simulated time."""
        self._models, self._requests, self._time_s = models, requests, time_s
        self._states = rospy.Publisher('~model_states', ModelStates, queue_size=10)
        rospy.Service('~get_model_state', GetModelState, self._get)
        rospy.Service('~set_model_state', SetModelState, self._set)

    def update(self) -> None:
        """Call in the loop: publish the states of all models."""
        if self._states.get_num_connections():
            msg = ModelStates()
            for name in self._models.names:
                state = self._models.state(name)
                msg.name.append(name)
                msg.pose.append(_pose_of(state))
                msg.twist.append(_twist_of(state))
            self._states.publish(msg)

    def _get(self, request) -> 'GetModelStateResponse':
        frame = _frame_of(request.relative_entity_name)
        try:
            state, time_s = self._requests.call(
                lambda: (self._models.state(request.model_name, frame), self._time_s()),
                _TIMEOUT_S)
        except (SimulationError, LateError) as error:
            return GetModelStateResponse(success=False, status_message=_words(error))
        answer = GetModelStateResponse(pose=_pose_of(state), twist=_twist_of(state), success=True)
        answer.header.stamp = robot_msgs.stamp_of(time_s)
        answer.header.frame_id = frame
        return answer

    def _set(self, request) -> 'SetModelStateResponse':
        wanted = request.model_state
        try:
            self._requests.call(lambda: self._models.set_state(
                wanted.model_name, _state_of(wanted), _frame_of(wanted.reference_frame)),
                _TIMEOUT_S)
        except (SimulationError, LateError) as error:
            return SetModelStateResponse(success=False, status_message=_words(error))
        return SetModelStateResponse(success=True)


def _frame_of(name: str) -> str:
    return WORLD if name in _WORLD_NAMES else name


def _words(error: Exception) -> str:
    return str(error) or 'the simulation does not answer'


def _pose_of(state: State) -> Pose:
    return Pose(Point(*state.position), Quaternion(*state.orientation))


def _twist_of(state: State) -> Twist:
    return Twist(Vector3(*state.linear), Vector3(*state.angular))


def _state_of(msg) -> State:
    place, turn = msg.pose.position, msg.pose.orientation
    linear, angular = msg.twist.linear, msg.twist.angular
    return State((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w),
                 (linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z))
