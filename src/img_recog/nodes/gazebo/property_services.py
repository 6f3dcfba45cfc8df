"""Gazebo's services that describe world and physics, where gazebo_msgs is installed."""
from typing import Callable, NamedTuple

import rospy
from geometry_msgs.msg import Vector3

from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.simulation.bodies.world import World
from img_recog.simulation.models import Models
from img_recog.simulation.settings import SimulationError

try:
    from gazebo_msgs.srv import (GetPhysicsProperties, GetPhysicsPropertiesResponse,
                                 GetWorldProperties, GetWorldPropertiesResponse)
except ImportError:
    pass        # see model_services.AVAILABLE


class Now(NamedTuple):
    """The state of the simulation: time in s, wanted factor, and whether it is paused."""

    time_s: float
    real_time_factor: float
    is_paused: bool


class PropertyServices:
    """Serves ~get_world_properties and ~get_physics_properties.

    Must be created only when model_services.AVAILABLE.
    """

    def __init__(self, models: Models, world: World, step_s: float, calls: ServiceCalls,
                 now: Callable[[], Now]):
        """Advertise; now: returns the state."""
        self._models, self._step_s, self._calls, self._now = models, step_s, calls, now
        self._gravity = Vector3(*world.file.gravity)
        rospy.Service('~get_world_properties', GetWorldProperties, self._describe_world)
        rospy.Service('~get_physics_properties', GetPhysicsProperties, self._describe_physics)

    def _describe_world(self, _: object) -> 'GetWorldPropertiesResponse':
        try:
            names, now = self._calls.call(lambda: (self._models.names, self._now()))
        except SimulationError as error:
            return GetWorldPropertiesResponse(success=False, status_message=str(error))
        return GetWorldPropertiesResponse(sim_time=now.time_s, model_names=names,
                                          rendering_enabled=True, success=True)

    def _describe_physics(self, _: object) -> 'GetPhysicsPropertiesResponse':
        try:
            now = self._calls.call(self._now)
        except SimulationError as error:
            return GetPhysicsPropertiesResponse(success=False, status_message=str(error))
        return GetPhysicsPropertiesResponse(
            time_step=self._step_s, pause=now.is_paused,
            max_update_rate=now.real_time_factor / self._step_s,
            gravity=self._gravity, success=True,
            status_message='simulated by PyBullet: ode_config is not used')
