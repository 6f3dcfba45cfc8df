"""Keeps the robots of the simulation those of the parameter ~robots."""
import threading
from functools import partial
from typing import Any, Callable, Dict, List, Tuple

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from img_recog.errors import UserError, one_line
from img_recog.nodes.gazebo.model_topics import WorldTopics
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.robot_reader import RobotReader
from img_recog.simulation.configured_model import ConfiguredModel


class RobotUpdates:
    """Makes the robots those of ~robots, also by the service ~update_robots (std_srvs/Trigger).

    A robot that fails does not keep the others from being there. The message of the response has a
    line for each one that fails: NAME: REASON.
    """

    def __init__(self, topics: WorldTopics, reader: RobotReader, calls: ServiceCalls):
        """Add the robots and advertise; the loop must not run yet."""
        self._topics, self._reader = topics, reader
        self._made: Dict[str, Tuple[Any, ...]] = {}     # from what each robot was made
        self._said: Dict[str, str] = {}                 # why a robot is not there
        self._lock = threading.Lock()       # of calls of the service
        self._call: Callable[[Callable[[], None]], Any] = lambda action: action()
        self._update()
        self._call = calls.call
        rospy.Service('~update_robots', Trigger, self._serve)

    def _serve(self, _: TriggerRequest) -> TriggerResponse:
        try:
            with self._lock:
                problems = self._update()
        except UserError as error:
            return TriggerResponse(False, one_line(error))
        return TriggerResponse(not problems, '\n'.join(problems))

    def _update(self) -> List[str]:
        """Add and remove; return the problems."""
        names = self._reader.names()
        problems = []
        for name in [name for name in self._made if name not in names] + names:
            try:
                if name in names:
                    self._make(name)
                else:
                    self._call(partial(self._remove, name))
                self._said.pop(name, None)
            except UserError as error:
                reason = one_line(error)
                problems.append('{}: {}'.format(name, reason))
                if self._said.get(name) != reason:
                    self._said[name] = reason
                    rospy.logerr('robot %s is not simulated: %s', name, reason)
        return problems

    def _make(self, name: str) -> None:
        snapshot = self._reader.snapshot(name)
        if self._made.get(name) == snapshot and name in self._topics:
            return
        spec = self._reader.named(name)      # before the one of that name is removed
        self._call(lambda: self._replace(spec, snapshot))

    def _replace(self, spec: ConfiguredModel, snapshot: Tuple[Any, ...]) -> None:
        """Add a robot; like `_remove` in what simulates, so that a late call is complete too."""
        if spec.name in self._made:
            self._remove(spec.name)
        self._topics.add(spec)
        self._made[spec.name] = snapshot

    def _remove(self, name: str) -> None:
        self._made.pop(name, None)
        if name in self._topics:
            self._topics.remove(name)
