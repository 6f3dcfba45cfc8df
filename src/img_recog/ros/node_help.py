"""The command line of the nodes; --help: their topics, services and parameters."""
import argparse
import os
import sys
from typing import Any, Mapping, Sequence, Type

import rosgraph

from img_recog.settings import Settings, allowed_text, setting_fields

# by the namespace of their parameters, such as '~'
SettingsClasses = Mapping[str, Sequence[Type[Settings]]]


def parse(docstring: str, settings: SettingsClasses) -> None:
    """Print the help of a node and exit, if the command line has --help or -h.

    That is the docstring of its module, and a line for each parameter. Remappings, parameters and
    all else are for rospy and the node.
    """
    lines = [docstring.strip(), '',
             'Parameters, with defaults and allowed values (their meanings: doc/reference.md):']
    lines += ['  {}{}: {} ({})'.format(namespace, field.name, _shown(field.default),
                                       allowed_text(field))
              for namespace, classes in settings.items() for each in classes
              for field in setting_fields(each)]
    parser = argparse.ArgumentParser(
        usage='rosrun img_recog {} [_PARAMETER:=VALUE ...] [TOPIC:=OTHER_TOPIC ...]'.format(
            os.path.basename(sys.argv[0])),
        description='\n'.join(lines).replace('%', '%%'), add_help=False, allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('-h', '--help', action='help', help=argparse.SUPPRESS)
    parser.parse_known_args(rosgraph.myargv()[1:])


def _shown(default: Any) -> str:
    if default is None:
        return 'required'
    return str(default).lower() if isinstance(default, bool) else str(default) or 'empty'
