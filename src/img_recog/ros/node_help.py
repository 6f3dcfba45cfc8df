"""The option --help of the nodes: what a node subscribes to, publishes, serves and reads."""
import os
import sys
from typing import Any, Mapping, Sequence, Type

import rosgraph

from img_recog.settings import Settings, allowed_text, setting_fields

# by the namespace of their parameters, such as '~'
SettingsClasses = Mapping[str, Sequence[Type[Settings]]]


def is_wanted() -> bool:
    """Return whether the command line has --help or -h, beside remappings and parameters."""
    return not {'-h', '--help'}.isdisjoint(rosgraph.myargv()[1:])


def text(docstring: str, settings: SettingsClasses) -> str:
    """Return the help of a node: the docstring of its module, and a line for each parameter."""
    lines = ['usage: rosrun img_recog {} [_PARAMETER:=VALUE ...] [TOPIC:=OTHER_TOPIC ...]'.format(
        os.path.basename(sys.argv[0])), '', docstring.strip(), '',
        'Parameters, with defaults and allowed values (their meanings: doc/reference.md):']
    lines += ['  {}{}: {} ({})'.format(namespace, field.name, _shown(field.default),
                                       allowed_text(field))
              for namespace, classes in settings.items() for each in classes
              for field in setting_fields(each)]
    return '\n'.join(lines) + '\n'


def _shown(default: Any) -> str:
    if default is None:
        return 'required'
    return str(default).lower() if isinstance(default, bool) else str(default) or 'empty'
