"""Checks that the topics of a robot are not those of others."""
from typing import List, Sequence

import rospy

from img_recog.errors import SimulationError
from img_recog.nodes.gazebo import camera_topics
from img_recog.simulation.robot_spec import RobotSpec

_TAKEN = '/clock', '/tf', '/tf_static', '/rosout', '/rosout_agg', '/diagnostics'


def check_topics(spec: RobotSpec, others: Sequence[RobotSpec]) -> None:
    """Raise a UserError if a topic has no valid name, or would be that of two sensors or of
    something else.

    others: those that have their topics.
    """
    camera_topics.check(each.names.seen(camera) for each in (*others, spec)
                        for camera in each.cameras)
    own, command = _published(spec), _command_topic(spec)
    published = {topic for each in others for topic in _published(each)}
    for topic in own:
        if own.count(topic) > 1 or topic in published:
            raise SimulationError('two sensors are on the topic {}'.format(topic),
                                  'give each another topic')
    commands = {_command_topic(each) for each in (*others, spec)}
    for topic in (*own, command):
        if topic in _TAKEN:
            raise SimulationError('the topic {} is not that of a robot'.format(topic),
                                  'give its plugin another one')
        if topic in commands and topic in {*own, *published}:
            raise SimulationError('a sensor and commands are on the topic {}'.format(topic),
                                  'give each another topic')


def _command_topic(spec: RobotSpec) -> str:
    return rospy.resolve_name(spec.names.topic(spec.settings.drive.command_topic))


def _published(spec: RobotSpec) -> List[str]:
    """Return the resolved names of the topics of the sensors.

    Sensors of a kind can share one, like in Gazebo.
    """
    found = dict.fromkeys(
        (topic, each.name if each.kind.is_drawn else each.kind.msg_type) for each in spec.sensors
        for topic in each.kind.topics(spec.settings.sensors[each.name]))
    return [rospy.resolve_name(spec.names.topic(topic)) for topic, _ in found]
