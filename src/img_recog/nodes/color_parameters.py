"""Reads the parameters of the color recognition from the parameter server."""
from functools import partial
from typing import Any, List, Sequence, Type

import rosgraph.names
import rospy

from img_recog.errors import shortened
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC, unknown_color
from img_recog.recognition.recognition_settings import (DEFAULT_COLORS, RecognitionSettings,
                                                        color_in, color_names, with_colors)
from img_recog.ros import parameters
from img_recog.settings import SettingError, Settings


def read(namespace: str = '~') -> RecognitionSettings:
    """Return the settings given by the parameters of a node, with the colors in ~colors.

    namespace: the resolved name of the node, if it is not this one.
    Raises ParameterError naming the parameter, its value and the allowed values.
    """
    names = parameters.read_one(COLORS, list(DEFAULT_COLORS), color_names, namespace)
    return parameters.read(with_colors(names), namespace=namespace)


def read_image_topics(settings: RecognitionSettings, used_topics: Sequence[str]) -> List[str]:
    """Return for each color the topic of its masked images, by default NAME_image.

    used_topics: topics that the node already uses.
    Raises ParameterError for a topic name that is invalid or already used.
    """
    used = {rospy.resolve_name(topic) for topic in used_topics}

    def checked(parameter: str, topic: Any) -> str:
        if not (isinstance(topic, str) and topic and rosgraph.names.is_legal_name(topic)):
            raise SettingError(parameter, topic, 'a valid topic name')
        if rospy.resolve_name(topic) in used:
            raise SettingError(parameter, topic, 'a topic that this node does not already use')
        used.add(rospy.resolve_name(topic))
        return topic
    topic_parameters = (IMAGE_TOPIC.format(name) for name in settings.color_names)
    return [parameters.read_one(parameter, name + '_image', partial(checked, parameter))
            for parameter, name in zip(topic_parameters, settings.color_names)]


def warn_of_unknown(settings: RecognitionSettings, *others: Type[Settings]) -> None:
    """Log one warning for each private parameter that the node does not have.

    others: the other settings of the node.
    """
    known = [COLORS, *(IMAGE_TOPIC.format(name) for name in settings.color_names)]
    of_unknown_colors = []
    for name in parameters.names_in('~'):
        color = color_in(name)
        if color is not None and color not in settings.color_names:
            of_unknown_colors.append(name)
            rospy.logwarn('parameter %s: %s', shortened(rospy.resolve_name('~' + name)),
                          unknown_color(color, settings.color_names))
    parameters.warn_of_unknown(type(settings), *others, also_known=known + of_unknown_colors)
