"""The topics and services of Gazebo for the links and joints of models."""
from functools import partial
from typing import Any, Callable, Dict, Tuple

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion

from img_recog.errors import SimulationError
from img_recog.model import NO_INERTIA
from img_recog.nodes.gazebo.model_services import (MISSING, Response, frame_of, pose_of, serve,
                                                   twist_of, vector_of)
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.simulation.models import LINK_SEPARATOR, Models, State, in_world
from img_recog.simulation.simulator import Simulator

if not MISSING:
    from gazebo_msgs.msg import LinkState, LinkStates
    from gazebo_msgs.srv import (ApplyBodyWrench, ApplyJointEffort, BodyRequest,
                                 GetJointProperties, GetLinkProperties, GetLinkState,
                                 GetModelProperties, JointRequest, SetModelConfiguration)


class LinkServices:
    """Publishes ~link_states, and serves what the constructor names.

    Must be created only when nothing is MISSING.
    """

    def __init__(self, simulator: Simulator, models: Models, calls: ServiceCalls):
        """Advertise."""
        self._step_s, self._models, self._calls = simulator.world.step_s, models, calls
        self._states = rospy.Publisher('~link_states', LinkStates, queue_size=10)
        serve({'get_link_state': (GetLinkState, self._get_state),
               'get_link_properties': (GetLinkProperties, self._describe_link),
               'get_joint_properties': (GetJointProperties, self._describe_joint),
               'get_model_properties': (GetModelProperties, self._describe_model),
               'set_model_configuration': (SetModelConfiguration, self._set_joints),
               'apply_body_wrench': (ApplyBodyWrench, self._apply_wrench),
               'apply_joint_effort': (ApplyJointEffort, self._apply_effort)})
        # their responses are empty
        for name, kind, field, clear in (
                ('clear_body_wrenches', BodyRequest, 'body_name', self._models.clear_wrenches),
                ('clear_joint_forces', JointRequest, 'joint_name', self._models.clear_efforts)):
            rospy.Service('~' + name, kind, partial(self._clear, clear, field))

    def update(self) -> None:
        """Publish the states of all links; to be called by the loop."""
        if self._states.get_num_connections():
            msg = LinkStates()
            for model, body in self._models.bodies:
                for link in body.link_names:
                    state = in_world(body.motion(link))
                    msg.name.append(model + LINK_SEPARATOR + link)
                    msg.pose.append(pose_of(state))
                    msg.twist.append(twist_of(state))
            self._states.publish(msg)

    def _get_state(self, request: Any) -> Response:
        def read() -> State:
            self._models.link(request.link_name)
            return self._models.state(request.link_name, frame_of(request.reference_frame))
        state = self._calls.call(read)
        return {'link_state': LinkState(request.link_name, pose_of(state), twist_of(state),
                                        request.reference_frame)}

    def _describe_link(self, request: Any) -> Response:
        body, name = self._calls.call(lambda: self._models.link(request.link_name))
        link = next(each for each in body.model.links if each.name == name)
        inertia = link.inertia or NO_INERTIA
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertia.matrix.tolist()
        # like in Gazebo, which does not say how the axes of the inertia are turned
        return {'com': Pose(Point(*inertia.pose.translation.tolist()), Quaternion(0, 0, 0, 1)),
                'gravity_mode': inertia.mass > 0 and link.has_gravity is not False,
                'mass': inertia.mass, 'ixx': ixx, 'ixy': ixy, 'ixz': ixz, 'iyy': iyy, 'iyz': iyz,
                'izz': izz}

    def _describe_joint(self, request: Any) -> Response:
        def read() -> Tuple[float, float]:
            body, joint = self._models.joint(request.joint_name)
            return body.joint_state(body.first_axes[joint])
        position, rate = self._calls.call(read)
        # like gazebo_ros, with the type 0 whatever it is, and without damping
        return {'position': [position], 'rate': [rate]}

    def _describe_model(self, request: Any) -> Response:
        bodies = self._calls.call(lambda: self._models.model(request.model_name).bodies)
        joints = [name for body in bodies for name in (*body.model.held, *body.first_axes)]
        return {'body_names': [link for body in bodies for link in body.link_names],
                'joint_names': joints,
                'is_static': not joints and all(body.fixed for body in bodies)}

    def _set_joints(self, request: Any) -> Response:
        names, positions = request.joint_names, request.joint_positions
        if len(names) != len(positions):
            raise SimulationError('got {} joint_names and {} joint_positions'.format(
                len(names), len(positions)), 'give a position for each joint')
        self._calls.call(lambda: self._models.set_joints(
            request.model_name, dict(zip(names, positions))))
        return {}

    def _apply_wrench(self, request: Any) -> Response:
        wrench = request.wrench
        self._calls.call(lambda: self._models.apply_wrench(
            request.body_name, vector_of(wrench.force), vector_of(wrench.torque),
            request.start_time.to_sec(), request.duration.to_sec(),
            vector_of(request.reference_point), frame_of(request.reference_frame)))
        return self._lasting(request)

    def _apply_effort(self, request: Any) -> Response:
        self._calls.call(lambda: self._models.apply_effort(
            request.joint_name, request.effort, request.start_time.to_sec(),
            request.duration.to_sec()))
        return self._lasting(request)

    def _lasting(self, request: Any) -> Response:
        is_short = 0 < request.duration.to_sec() < self._step_s
        return {'status_message': 'duration: a step of {:g} s is the least'.format(
            self._step_s) if is_short else ''}

    def _clear(self, clear: Callable[[str], None], field: str, request: Any) -> Dict[str, Any]:
        self._calls.call(lambda: clear(getattr(request, field)))
        return {}
