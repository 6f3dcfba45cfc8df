#!/usr/bin/env python3
"""Check the arguments of ./run demo before anything starts.

roslaunch ignores arguments that the launch file does not have, and prints its usage when a colon
is missing. What it or rosbag would say in many lines, or in none, gives one line here, too. All
other values are checked by the nodes.
"""
import os
import re
import shutil
import sys
import textwrap

import launch_files
from img_recog.command_line.messages import message
from img_recog.errors import most_similar, shortened

# options of roslaunch that are followed by a value
OPTIONS_WITH_VALUE = ('-p', '--port', '-t', '--timeout', '-u', '--server_uri', '-w',
                      '--numworkers',
                      '--args', '--find-node', '--master-logger-level', '--pid',
                      '--run_id', '--sigint-timeout', '--sigterm-timeout')
MAX_INT = 0x7fffffff        # roslaunch cannot send larger integers to the master
TRUE_OR_FALSE = ('true', 'false', '1', '0')
MEANT = {'true': ('yes', 'on', 'y', 't'), 'false': ('no', 'off', 'n', 'f', 'none', 'never')}
HELP = {'-h', '--help'}
# arguments that are paths, and what else they may be
PATHS = {'camera': 'auto|synthetic|robot|none|.*://.*', 'colors': '', 'record': 'none',
         'robots': r'none|[+-]?\d+', 'urdf': ''}


class ArgumentError(Exception):
    """A word on the command line that roslaunch would refuse or misunderstand."""

    def __init__(self, text, *values):
        """text: as for `message`."""
        super().__init__(message(text, *values))


class Arguments:
    """The arguments of demo.launch and of its parts, and their allowed values."""

    def __init__(self, launch_file):
        roots = launch_files.with_parts(launch_file)
        self._arguments = launch_files.taken(roots)
        self._switches = {name for name in self._arguments
                          if any(_is_switch(root, name) for root in roots.values())}

    def help(self):
        """Return all arguments in their groups, with their defaults and meanings."""
        width = min(99, shutil.get_terminal_size().columns)
        lines, group = ['usage: ./run demo [ARGUMENT:=VALUE ...] [OPTION of roslaunch ...]'], ''
        for each in self._arguments.values():
            if each.group != group:
                group = each.group
                lines += ['', group]
            default = ':=' + each.default.replace('$(find img_recog)/', '')
            lines += ['  ' + each.name + default * ('$(' not in default),    # else in doc
                      textwrap.fill(each.doc, width, initial_indent=' ' * 6,
                                    subsequent_indent=' ' * 6)]
        return '\n'.join(lines) + '\n'

    def checked(self, words):
        """Return the words with absolute paths, for roslaunch; raise ArgumentError."""
        result, following = [], [*words[1:], '']
        is_value = False            # of the option before
        for word, after in zip(words, following):
            name, assigned, value = word.partition(':=')
            if is_value:
                is_value = False
            elif word.startswith('-'):
                is_value = word in OPTIONS_WITH_VALUE
                if is_value and not after:
                    raise ArgumentError('{} needs a value', word)
            elif assigned and not value and after and ':=' not in after and after[:2] != '--':
                raise ArgumentError('got a space after {}; write {}{}', word, word, after)
            elif after.startswith(':=') or not name:
                raise ArgumentError(
                    'got a space before :=; write {}', 'ARGUMENT:=VALUE' if not name else
                    name + (after if after != ':=' else ':=VALUE'))
            elif not assigned:
                self._refuse(word)
            elif not name.startswith('__'):     # which is of roslaunch
                word = '{}:={}'.format(name, self._value(name, value))
            result.append(word)
        return result

    def _refuse(self, word):
        name, equals, value = word.partition('=')
        if equals and name in self._arguments:
            raise ArgumentError('got {}; write {}:={}', word, name, value)
        raise ArgumentError('got {}; write arguments like camera:=synthetic; ./run demo --help '
                            'lists them', word)

    def _value(self, name, value):
        if name not in self._arguments:
            similar = most_similar(name, self._arguments)
            if similar:
                raise ArgumentError('demo.launch has no argument {}; did you mean {}?',
                                    name, similar)
            raise ArgumentError('demo.launch has no argument {}; ./run demo --help lists them',
                                name)
        if value == '':
            raise ArgumentError('{} has no value: roslaunch ignores it; write {}:=VALUE, or leave '
                                'it out', name, name)
        if name in self._switches and value.lower() not in TRUE_OR_FALSE:
            meant = next((switch for switch, words in MEANT.items() if value.lower() in words), '')
            raise ArgumentError('{}: got {}, allowed is true or false; write {}', name, value,
                                '{}:={}'.format(name, meant) if meant else
                                message('{} or {}', name + ':=true', name + ':=false'))
        # PWD keeps symlinks, unlike os.getcwd(): the path is the one that the user sees
        path = os.path.join(os.environ.get('PWD') or os.getcwd(), os.path.expanduser(value))
        if name in PATHS and not re.fullmatch(PATHS[name], value.lower()):
            value = path
        elif name == 'world' and os.path.isfile(path):
            value = path            # else it may be a name, or in a folder of Gazebo
        if re.fullmatch(r'[+-]?\d+', value) and abs(int(value)) > MAX_INT:
            raise ArgumentError('{}: got {}, allowed are integers of at most 32 bits', name,
                                shortened(value))
        if name == 'record' and value != 'none':
            _check_record(value)
        if name == 'record_size' and not value.isdigit():
            raise ArgumentError('{}: got {}, allowed is a whole number, 0 or more', name, value)
        if name == 'urdf' and '.xacro' in value and "'" in value:
            raise ArgumentError('{}: roslaunch cannot pass on the apostrophe in {}; rename the '
                                'file or its folder', name, value)
        return value


def _is_switch(root, name):
    """Return whether an argument is true or false, by its default or by where it is used."""
    use = '$(arg {})'.format(name)
    return any((element.get('name') == name and element.get('default') in TRUE_OR_FALSE[:2]) or
               use in (element.get('if'), element.get('unless')) or
               (element.get('type') == 'bool' and element.get('value') == use)
               for element in root.iter())


def _check_record(path):
    """Raise ArgumentError for the path of a bag which rosbag would not write, or replace."""
    if "'" in path:
        raise ArgumentError('{}: got {}, allowed is a path without an apostrophe; write for '
                            'example {}:=demo.bag', 'record', path, 'record')
    # rosbag adds the suffix, and replaces a file without a word
    bag = path if path.endswith('.bag') else path + '.bag'
    if os.path.exists(bag):
        raise ArgumentError('{}: {} exists; give another name, or remove it', 'record', bag)
    if os.path.exists(bag + '.active'):
        raise ArgumentError('{}: {}.active exists: another demo records it, or has not '
                            'completed it; give another name, or rename it and run "rosbag '
                            'reindex" on it', 'record', bag)
    folder = os.path.dirname(bag)
    if not (os.path.isdir(folder) and os.access(folder, os.W_OK)):
        raise ArgumentError('{}: {} is no folder where files can be written; make it, or give '
                            'another path', 'record', folder)


def main(launch_file, *words):
    """Check the words; return the exit code."""
    try:
        arguments = Arguments(launch_file)
        if HELP.intersection(words):
            sys.stdout.write(arguments.help())
        else:
            arguments.checked(words)
    except ArgumentError as error:
        sys.stderr.write('[run] {}\n'.format(error))
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
