"""Settings that can be changed at runtime, by dynamic_reconfigure without a .cfg file."""
import dataclasses
from itertools import chain
from types import SimpleNamespace
from typing import Callable, Generic, Optional, Type

import rospy
from dynamic_reconfigure.encoding import Config, encode_config
from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.server import Server
from dynamic_reconfigure.srv import ReconfigureRequest

from img_recog.errors import UserError, one_line, shortened
from img_recog.settings import (MAX_INT, SettingError, Settings, SettingsType, allowed_text,
                                setting_fields)

# dynamic_reconfigure's names for the types, and its bounds where a field has none.
_TYPES = {bool: 'bool', int: 'int', float: 'double', str: 'str'}
_BOUNDS = {bool: (False, True), int: (-MAX_INT - 1, MAX_INT),
           float: (-float('inf'), float('inf')), str: ('', '')}


def config_type(settings_class: Type[Settings]) -> SimpleNamespace:
    """Return what dynamic_reconfigure's generator makes of a .cfg file, for a settings class.

    Names, defaults, types, bounds, choices and descriptions are those of the fields. Integers
    must fit into 32 bits.
    """
    described = [_describe(field) for field in setting_fields(settings_class)]
    by_name = {key: {each['name']: each[key] for each in described}
               for key in ('min', 'max', 'level', 'type')}
    return SimpleNamespace(
        config_description={'name': 'Default', 'type': '', 'state': True, 'cstate': 'true',
                            'id': 0, 'parent': 0, 'parameters': described, 'groups': []},
        defaults=Config((each['name'], each['default']) for each in described),
        all_level=0, **by_name)


class Reconfigurable(Server, Generic[SettingsType]):
    """Serves settings under a namespace as dynamic_reconfigure's tools expect them.

    Publishes, latched: parameter_descriptions (dynamic_reconfigure/ConfigDescription) and
    parameter_updates (dynamic_reconfigure/Config). Serves: set_parameters
    (dynamic_reconfigure/Reconfigure). Writes the current values to the parameter server, where
    those tools and the next start of the node find them.

    It is the distribution's server without its own checks: that would read the parameter server
    again, would clamp a value that is out of bounds instead of refusing it, and fails on groups
    that it does not have. A value of a wrong name or type is left out, as in C++; any other wrong
    value refuses the whole request.

    settings: the current ones.
    """

    def __init__(self, settings: SettingsType, on_change: Callable[[SettingsType], None],
                 namespace: Optional[str] = None):
        """Start to serve.

        settings: the current values; they are not read from the parameter server here.
        on_change: called with the new settings, in the thread of the service, one call at a
        time; raises a UserError to refuse them.
        namespace: a resolved name; the node's by default.
        """
        self.settings, self._on_change = settings, on_change
        self._namespace = namespace or rospy.get_name()
        super().__init__(config_type(type(settings)), self._apply, self._namespace)

    def close(self) -> None:
        """Stop serving."""
        self.set_service.shutdown('closed')
        self.descr_topic.unregister()
        self.update_topic.unregister()

    def _copy_from_parameter_server(self) -> None:
        self.config.update(_values(self.settings))

    def _clamp(self, config: Config) -> None:
        pass

    def _set_callback(self, request: ReconfigureRequest) -> ConfigMsg:
        fields = {field.name: field for field in setting_fields(type(self.settings))}
        values, sent = {}, request.config
        for each in chain(sent.bools, sent.ints, sent.strs, sent.doubles):
            field = fields.get(each.name)
            kind = field and field.metadata['kind']
            if type(each.value) is kind or (kind is float and type(each.value) is int):
                values[each.name] = each.value
            else:
                allowed = 'one of the parameters ' + ', '.join(fields)
                self._log_refusal(SettingError(
                    each.name, each.value, allowed_text(field) if field else allowed), 'it is not')
        return encode_config(self.update_configuration(values))

    def _apply(self, config: Config, _level: int) -> Config:
        """Apply the values, or log why not; return the current ones."""
        try:
            settings = dataclasses.replace(self.settings, **{
                name: value for name, value in config.items() if name != 'groups'})
            if settings != self.settings:
                self._on_change(settings)
                self.settings = settings
        except UserError as error:
            self._log_refusal(error)
        config.update(_values(self.settings))
        return config

    def _log_refusal(self, error: UserError, what: str = 'nothing is') -> None:
        if isinstance(error, SettingError):
            rospy.logerr('parameter %s/%s: got %s, allowed is %s; %s changed', self._namespace,
                         shortened(error.name), error.got, error.allowed, what)
        else:
            rospy.logerr('parameters of %s: %s; %s changed', self._namespace, one_line(error),
                         what)


def _values(settings: Settings) -> dict:
    return {field.name: getattr(settings, field.name) for field in setting_fields(type(settings))}


def _describe(field) -> dict:
    kind, allowed = field.metadata['kind'], field.metadata['allowed']
    low, high = _BOUNDS[kind]
    if kind in (int, float):
        low = low if allowed.low is None else kind(allowed.low)
        high = high if allowed.high is None else kind(allowed.high)
    default = kind() if field.default is None else field.default
    return {'name': field.name, 'type': _TYPES[kind], 'default': default, 'level': 0,
            'min': low, 'max': high, 'description': field.metadata['description'],
            'edit_method': _edit_method(field.name, allowed.choices)}


def _edit_method(name: str, choices) -> str:
    """Return the text from which tools make a list of choices; empty for no list."""
    if not choices:
        return ''
    enum = [{'name': choice, 'type': 'str', 'value': choice, 'description': '', 'srcline': 0,
             'srcfile': '', 'ctype': 'std::string', 'cconsttype': 'const char * const'}
            for choice in choices]
    return repr({'enum': enum, 'enum_description': name})
