"""The parameters of the recognition on the parameter server."""
from functools import partial
from typing import Any, List, Sequence, Type

import rosgraph.names
import rospy

from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC, no_such_color
from img_recog.recognition.settings import (DEFAULT_COLORS, RecognitionSettings, color_in,
                                            color_names, with_colors)
from img_recog.ros import parameters
from img_recog.settings import SettingError, Settings


def read(namespace: str = '~') -> RecognitionSettings:
    """Return the settings that the parameters of a node make: its `colors` and those of each.

    namespace: the resolved name of the node, if it is not this one.
    Raises ParameterError naming the parameter, its value and what is allowed.
    """
    names = parameters.read_one(COLORS, list(DEFAULT_COLORS), color_names, namespace)
    return parameters.read(with_colors(names), namespace=namespace)


def read_image_topics(settings: RecognitionSettings, taken: Sequence[str]) -> List[str]:
    """Return for each color the topic of its masked images, by default NAME_image.

    taken: topics that the node uses already.
    Raises ParameterError for one that is no name of a topic, or has another use.
    """
    used = {rospy.resolve_name(topic) for topic in taken}

    def checked(parameter: str, topic: Any) -> str:
        if not (isinstance(topic, str) and topic and rosgraph.names.is_legal_name(topic)):
            raise SettingError(parameter, topic, 'the name of a topic')
        if rospy.resolve_name(topic) in used:
            raise SettingError(parameter, topic, 'a topic that this node has no other use for')
        used.add(rospy.resolve_name(topic))
        return topic
    names = (IMAGE_TOPIC.format(name) for name in settings.color_names)
    return [parameters.read_one(parameter, name + '_image', partial(checked, parameter))
            for parameter, name in zip(names, settings.color_names)]


def warn_of_unknown(settings: RecognitionSettings, *others: Type[Settings]) -> None:
    """Log one warning for each private parameter that the node does not have.

    others: the settings that it has besides.
    """
    known = [COLORS, *(IMAGE_TOPIC.format(name) for name in settings.color_names)]
    strangers = [name for name in parameters.names_in('~')
                 if color_in(name) not in (None, *settings.color_names)]
    for name in strangers:
        rospy.logwarn('parameter %s: %s', rospy.resolve_name('~' + name),
                      no_such_color(name, settings.color_names))
    parameters.warn_of_unknown(type(settings), *others, also_known=known + strangers)
