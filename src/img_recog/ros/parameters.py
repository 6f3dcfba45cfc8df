"""The one place where the parameter server is read."""
import xmlrpc.client
from types import MappingProxyType
from typing import Any, Callable, Iterable, List, Mapping, Type

import rospy

from img_recog.errors import one_line
from img_recog.settings import (ParameterError, SettingError, Settings, SettingsType, allowed_text,
                                from_mapping, setting_fields, unknown)

LOG_TOPICS_ARE_LEFT_OUT = '/rosout_disable_topics_generation'      # rospy's name
_NO_VALUES: Mapping[str, Any] = MappingProxyType({})


def read(settings_class: Type[SettingsType],
         from_description: Mapping[str, Any] = _NO_VALUES,
         namespace: str = '~', fallback: str = '') -> SettingsType:
    """Return the settings; private parameters override the fields of the same name.

    from_description: values of a robot description, which override the defaults; parameters
    override both.
    namespace: to read parameters other than the private ones. fallback: the namespace whose
    parameters hold where there is none in `namespace`; '' for none.
    Logs a warning for each parameter in place of which another value is used, like in roscpp.
    Raises ParameterError naming the parameter, its value and what is allowed.
    """
    own, others = _parameters_in(namespace), _parameters_in(fallback) if fallback else _NO_VALUES
    try:
        settings = from_mapping(settings_class, {**from_description, **others, **own})
    except SettingError as error:
        where = '{}, as robot_description states it'.format(error.name)
        if error.name in own or error.name not in from_description:
            where = 'parameter ' + _name_in(namespace, error.name)
        elif error.name in others:
            where = 'parameter ' + _name_in(fallback, error.name)
        raise ParameterError('{}: got {}, allowed is {}'.format(where, error.got, error.allowed))
    for field in setting_fields(settings_class) if settings.is_like_roscpp else ():
        used = getattr(settings, field.name)
        if own.get(field.name, used) != used:
            rospy.logwarn('parameter %s; using %r', SettingError(
                _name_in(namespace, field.name), own[field.name], allowed_text(field)), used)
    return settings


def read_one(name: str, default: Any, checked: Callable[[Any], Any], namespace: str = '~') -> Any:
    """Return the private parameter `name` as `checked` returns it.

    checked: raises SettingError for a value that is not allowed.
    namespace: as for `read`.
    Raises ParameterError naming the parameter, its value and what is allowed.
    """
    try:
        return checked(_parameters_in(namespace).get(name, default))
    except SettingError as error:
        raise ParameterError('parameter {}: got {}, allowed is {}'.format(
            _name_in(namespace, name), error.got, error.allowed))


def warn_of_unknown(*settings_classes: Type[Settings], also_known: Iterable[str] = (),
                    namespace: str = '~', meant: Mapping[str, str] = _NO_VALUES) -> None:
    """Log a warning for each private parameter that no settings class has: a likely typo.

    also_known: more names without a warning, as of the namespaces of a topic's parameters.
    namespace: as for `read`. meant: as for `unknown`.
    """
    known = {field.name for each in settings_classes for field in setting_fields(each)}
    known.update(also_known)
    for name in sorted(set(_parameters_in(namespace)) - known):
        rospy.logwarn('%s', unknown(name, known, _name_in(namespace, name), meant))


def names_in(namespace: str) -> List[str]:
    """Return the sorted names of the parameters in a namespace."""
    return sorted(_parameters_in(namespace))


def value(name: str) -> Any:
    """Return a parameter, or a dict of those in a namespace; None when there is none."""
    return _get(name, None)


def robot_description(name: str = '') -> str:
    """Return the URDF on the parameter server.

    name: of the parameter; '' for robot_description in this namespace or the nearest one above.
    Raises ParameterError when there is none.
    """
    name = name or rospy.search_param('robot_description')
    text = _get(name, None) if name else None
    if not isinstance(text, str):
        raise ParameterError(
            'parameter {}: got {}, wants the text of a URDF; load one with '
            '<param name="robot_description" textfile="..."/>'.format(
                name or rospy.resolve_name('robot_description'),
                'none' if text is None else type(text).__name__))
    return text


def log_topics_are_left_out() -> bool:
    """Return whether messages on /rosout do not list the topics of their node."""
    return rospy.get_param(LOG_TOPICS_ARE_LEFT_OUT, False)


def _parameters_in(namespace: str) -> dict:
    found = _get(namespace, {})
    return found if isinstance(found, dict) else {}


def _get(name: str, default: Any) -> Any:
    """Return a parameter, or a dict of those in a namespace.

    Raises ParameterError if the master has a value that XML-RPC cannot transmit.
    """
    try:
        return rospy.get_param(name, default)
    except xmlrpc.client.Fault as fault:
        raise ParameterError(unreadable(rospy.resolve_name(name), fault))


def unreadable(namespace: str, fault: xmlrpc.client.Fault) -> str:
    """Return the reason why the master does not send the parameters in a namespace."""
    return ('the parameters in {0}: the master cannot send them ({1}), wants integers of at most '
            '32 bits; delete the wrong one with rosparam delete {0}/NAME, or all of them with '
            'rosparam delete {0}'.format(namespace.rstrip('/'), one_line(fault.faultString)))


def _name_in(namespace: str, name: str) -> str:
    return rospy.resolve_name(('~' if namespace == '~' else namespace + '/') + name)
