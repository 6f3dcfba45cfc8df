"""Checks that the topics of a robot have valid names, and are not those of others."""
from typing import Callable, Dict, List, Sequence

import rosgraph

from img_recog.errors import SimulationError
from img_recog.settings import SettingError
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.simulation_settings import topic_fields

_TAKEN = '/clock', '/tf', '/tf_static', '/rosout', '/rosout_agg', '/diagnostics'
# Returns the global name of a topic.
Resolve = Callable[[str], str]


def check_topics(spec: ConfiguredModel, others: Sequence[ConfiguredModel],
                 resolve: Resolve) -> None:
    """Raise a UserError if a topic has no valid name, or would be that of two sensors or of
    something else.

    others: those that have their topics.
    """
    for settings in (spec.settings.drive, *spec.settings.sensors.values()):
        for setting in topic_fields(settings):
            topic = spec.names.topic(getattr(settings, setting))
            if not rosgraph.names.is_legal_name(topic):
                raise SettingError(setting, topic, 'a valid topic name')
    robots = spec, *others
    _check_cameras((*others, spec), resolve)
    command, *commands = [resolve(each.names.topic(each.settings.drive.command_topic))
                          for each in robots]
    own, *published = [_published(each, resolve) for each in robots]
    for topic in own:
        if own.count(topic) > 1 or any(topic in each for each in published):
            raise SimulationError('two sensors are on the topic {}'.format(topic),
                                  'give each another topic')
    for topic in (*own, command):
        if topic in _TAKEN:
            raise SimulationError('the topic {} is not that of a robot'.format(topic),
                                  'give its plugin another one')
        if topic in (command, *commands) and any(topic in each for each in (own, *published)):
            raise SimulationError('a sensor and commands are on the topic {}'.format(topic),
                                  'give each another topic')


def _check_cameras(specs: Sequence[ConfiguredModel], resolve: Resolve) -> None:
    owners: Dict[str, str] = {}
    for spec in specs:
        for camera in [spec.names.seen(each) for each in spec.cameras]:
            for setting in topic_fields(camera):
                topic = getattr(camera, setting)
                owner = '{} of the camera on {}'.format(setting, camera.camera_frame)
                other = owners.setdefault(resolve(topic), owner)
                if other is not owner:
                    raise SimulationError(
                        'the topic {} is {} and {}'.format(topic, other, owner),
                        'give each camera other topics: in a <gazebo> tag, another <cameraName>; '
                        'as parameters, another ' + setting)


def _published(spec: ConfiguredModel, resolve: Resolve) -> List[str]:
    """Return the resolved names of the topics of the sensors.

    Sensors of a kind can share one, like in Gazebo.
    """
    found = dict.fromkeys((topic, each.kind.msg_type) for each in spec.sensors
                          for topic in each.kind.topics(spec.settings.sensors[each.name]))
    return [resolve(spec.names.topic(topic)) for topic, _ in found]
