"""The parameters of the recognition: those of a node, or those in a file for one."""
from functools import partial
from typing import Any, List, Mapping, Sequence, Type

import rosgraph.names
import rospy
import yaml

from img_recog.recognition.settings import (DEFAULT_COLORS, RecognitionSettings, color_in,
                                            color_names, with_colors)
from img_recog.ros import parameters
from img_recog.ros.parameters import ParameterError
from img_recog.settings import SettingError, Settings, declared, made_of

COLORS = 'colors'
_IMAGE_TOPIC = '{}_image_topic'
# of the node alone, and of no matter to those who recognize without it
_NODE_ONLY = ('colors_file', 'image_transport')


def read(namespace: str = '~') -> RecognitionSettings:
    """Return the settings that the parameters of a node make: its `colors` and those of each.

    namespace: the resolved name of the node, if it is not this one.
    Raises ParameterError naming the parameter, its value and what is allowed.
    """
    names = parameters.read_one(COLORS, list(DEFAULT_COLORS), color_names, namespace)
    return parameters.read(with_colors(names), namespace=namespace)


def read_image_topics(settings: RecognitionSettings, taken: Sequence[str]) -> List[str]:
    """Return for each colour the topic of its masked images, by default NAME_image.

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
    names = (_IMAGE_TOPIC.format(name) for name in settings.color_names)
    return [parameters.read_one(parameter, name + '_image', partial(checked, parameter))
            for parameter, name in zip(names, settings.color_names)]


def warn_of_unknown(settings: RecognitionSettings, *others: Type[Settings]) -> None:
    """Log one warning for each private parameter that the node does not have.

    others: the settings that it has besides.
    """
    known = [COLORS, *(_IMAGE_TOPIC.format(name) for name in settings.color_names)]
    strangers = [name for name in parameters.names_in('~')
                 if color_in(name) not in (None, *settings.color_names)]
    for name in strangers:
        rospy.logwarn('parameter %s: %s', rospy.resolve_name('~' + name),
                      _no_such_color(name, settings.color_names))
    parameters.warn_of_unknown(type(settings), *others, besides=known + strangers)


def from_file(path: str) -> RecognitionSettings:
    """Return the settings in a YAML file as the node's parameters are loaded from.

    Raises ParameterError naming file, parameter, value and what is allowed.
    """
    values = _mapping(path)
    try:
        names = color_names(values.pop(COLORS, list(DEFAULT_COLORS)))
        kind = with_colors(names)
        known = {field.name for field in declared(kind)}
        others = {*_NODE_ONLY, *(_IMAGE_TOPIC.format(name) for name in names)}
        for name in values:
            if color_in(name) not in (None, *names):
                raise ParameterError('{}: parameter {}: {}'.format(
                    path, name, _no_such_color(name, names)))
            if name not in known | others:
                raise ParameterError('{}: {}'.format(path, parameters.unknown(name, known)))
        return made_of(kind, values)
    except SettingError as error:
        raise ParameterError('{}: parameter {}: got {}, allowed is {}'.format(
            path, error.name, error.got, error.allowed))


def _no_such_color(parameter: str, names: Sequence[str]) -> str:
    name = color_in(parameter)
    return 'there is no colour {}, the colours are {}; add it to {}: [{}]'.format(
        name, ', '.join(names), COLORS, ', '.join([*names, name]))


def _mapping(path: str) -> Mapping[str, Any]:
    try:
        with open(path) as file:
            values = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError('cannot read the parameters in {}: {}'.format(
            path, ' '.join(str(getattr(error, 'strerror', None) or error).split())))
    if not isinstance(values, dict) or not values:
        raise ParameterError('cannot use the parameters in {}: got {}, wants lines like '
                             'colors: [blue, red] and blue_hue_min: 50'.format(
                                 path, 'nothing' if not values else type(values).__name__))
    for name in values:
        if not isinstance(name, str):
            raise ParameterError('{}: got {!r} in the place of the name of a parameter'.format(
                path, name))
    return values
