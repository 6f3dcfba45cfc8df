#!/usr/bin/env python3
"""Check the arguments of ./run demo before anything starts.

roslaunch ignores arguments that the launch file does not have, passes any value to the nodes, and
prints its usage when a colon is missing. Here each mistake gives one line.
"""
import os
import re
import shutil
import sys
import textwrap

import launch_files
from img_recog.command_line.messages import message
from img_recog.errors import most_similar

# options of roslaunch that are followed by a value
OPTIONS_WITH_VALUE = ('-p', '--port', '-t', '--timeout', '-u', '--server_uri', '-w',
                      '--numworkers',
                      '--args', '--find-node', '--master-logger-level', '--pid',
                      '--run_id', '--sigint-timeout', '--sigterm-timeout')
URLS = ('http://', 'https://', 'rtmp://', 'rtsp://', 'rtsps://')
TRUE_OR_FALSE = ('true', 'false', '1', '0')
HELP = {'-h', '--help'}


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
        self._checks = {'camera': _camera, 'camera_info_url': _calibration, 'colors': _file,
                        'record': _record, 'robots': _robots, 'urdf': _urdf, 'world': _world}

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
        result, position = [], 0
        while position < len(words):
            word = words[position]
            name, assigned, value = word.partition(':=')
            following = words[position + 1] if position + 1 < len(words) else ''
            if word.startswith('-'):
                if word in OPTIONS_WITH_VALUE:
                    if not following:
                        raise ArgumentError('{} needs a value', word)
                    result.append(word)
                    position += 1
                    word = following
            elif assigned and not value and _is_value(following):
                raise ArgumentError('got a space after {}; write {}{}', word, word, following)
            elif following.startswith(':=') or not name:
                raise ArgumentError(
                    'got a space before :=; write {}', 'ARGUMENT:=VALUE' if not name else
                    name + (following if following != ':=' else ':=VALUE'))
            elif not assigned:
                self._refuse(word)
            elif not name.startswith('__'):     # which is of roslaunch
                word = '{}:={}'.format(name, self._value(name, value))
            result.append(word)
            position += 1
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
        if name in self._checks:
            return self._checks[name](name, value)
        if name in self._switches:
            if value.lower() not in TRUE_OR_FALSE:
                raise ArgumentError('{}: got {}, allowed is true or false; write {}:=true',
                                    name, _shown(value), name)
        return value        # demo_values.py checks numbers


def _is_switch(root, name):
    """Return whether an argument is true or false, by its default or by where it is used."""
    use = '$(arg {})'.format(name)
    return any((element.get('name') == name and element.get('default') in TRUE_OR_FALSE[:2]) or
               use in (element.get('if'), element.get('unless')) or
               (element.get('type') == 'bool' and element.get('value') == use)
               for element in root.iter())


def _is_value(word):
    return word != '' and ':=' not in word and not word.startswith('--')


def _shown(value):
    return repr(value) if value == '' or ' ' in value else value


def _absolute(path):
    # PWD keeps symlinks, unlike os.getcwd(): the path is the one that the user sees
    return os.path.join(os.environ.get('PWD') or os.getcwd(), os.path.expanduser(path))


def _file(_, value):
    return _absolute(value)     # which demo_values.py reads


def _urdf(name, value):
    path = _absolute(value)
    if '.xacro' in path and "'" in path:
        raise ArgumentError('{}: roslaunch cannot pass on the apostrophe in {}; rename the file '
                            'or its folder', name, path)
    return path


def _record(name, value):
    if value == 'none':
        return value
    path = _absolute(value)
    if value == '' or "'" in path:
        raise ArgumentError('{}: got {}, allowed is a path without an apostrophe; write for '
                            'example {}:=demo.bag', name, _shown(value), name)
    # rosbag adds the suffix, and replaces a file without a word
    bag = path if path.endswith('.bag') else path + '.bag'
    if os.path.exists(bag):
        raise ArgumentError('{}: {} exists; give another name, or remove it', name, bag)
    if os.path.exists(bag + '.active'):
        raise ArgumentError('{}: {}.active exists: another demo records it, or has not '
                            'completed it; give another name, or rename it and run "rosbag '
                            'reindex" on it', name, bag)
    folder = os.path.dirname(bag)
    if not (os.path.isdir(folder) and os.access(folder, os.W_OK)):
        raise ArgumentError('{}: {} is no folder where files can be written; make it, or give '
                            'another path', name, folder)
    return path


def _robots(_, value):
    return value if re.match(r'none$|[+-]?\d+$', value) else _absolute(value)


def _world(_, value):
    # else it may be a name, or in a folder of Gazebo
    return _absolute(value) if os.path.isfile(_absolute(value)) else value


def _camera(name, value):
    if value in ('auto', 'synthetic', 'robot', 'none') or value.lower().startswith(URLS):
        return value
    if '://' in value:
        raise ArgumentError('{}: got a URL of {}://; allowed are {}',
                            name, value.partition('://')[0], ', '.join(URLS))
    if value == '' or not os.path.exists(_absolute(value)):
        devices = sorted(word for word in os.listdir('/dev') if re.match(r'video\d+$', word))
        raise ArgumentError(
            '{}: got {}, which does not exist; allowed are auto, synthetic, robot, none, a URL, '
            'and the path of a video, image, folder or device (found: {})',
            name, _shown(value),
            ', '.join('/dev/' + word for word in devices) or message('no camera'))
    return _absolute(value)


def _calibration(name, value):
    scheme, separator, path = value.partition('://')
    if value == '' or (separator and scheme == 'package'):
        return value
    if scheme != 'file' or not path:
        raise ArgumentError('{}: got {}, allowed are file:///PATH and package://PACKAGE/PATH; '
                            'write for example {}:=file://{}',
                            name, _shown(value), name, _absolute('camera.yaml'))
    return value if path[0] in '/$' else 'file://' + _absolute(path)


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
