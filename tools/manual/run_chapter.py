#!/usr/bin/env python3
"""Run a chapter of TurtleBot3's e-Manual with this simulator in place of Gazebo.

The nodes and the launch files are those of the e-Manual: of the packages in your workspaces. This
program starts the simulator and them, does what the reader would do, and says how well it went.
"""
import argparse
import contextlib
import os
import signal
import subprocess
import sys
import time

import rosgraph
import rospkg
from chapters import CHAPTERS, DEBIAN, FILES
from tasks import TASKS, say

from img_recog import process_tree
from img_recog.errors import UserError
from img_recog.messages import message

_HERE = os.path.dirname(os.path.abspath(__file__))
_ROOT = os.path.dirname(os.path.dirname(_HERE))
_NOETIC = '/opt/ros/noetic'
_START_S, _END_S = 60.0, 20.0


def check_packages(chapter):
    """Raise UserError if a package of ROS that the chapter needs is missing."""
    packages = rospkg.RosPack()
    known = {name for name in packages.list() if name not in FILES
             or os.path.exists(os.path.join(packages.get_path(name), FILES[name]))}
    missing = [name for name in chapter.packages if name not in known]
    if not missing:
        return
    if os.path.isdir(_NOETIC):
        names = ' '.join(chapter.noetic)
    else:
        names = ' '.join(DEBIAN[name] for name in missing if name in DEBIAN)
    advice = [message('install {}', names)] if names else []
    if not set(missing) <= set(DEBIAN):
        advice.append(message('source the setup.bash of a workspace that has them before ./run; '
                              'see doc/manual.md'))
    raise UserError(message('these packages of ROS are missing: {}', ' '.join(missing)),
                    '; '.join(advice))


def filled(words):
    """Return words with the folders of packages in place of {NAME}, and of this one of {here}."""
    packages = rospkg.RosPack()

    class Folders(dict):
        def __missing__(self, name):
            return packages.get_path(name)
    return [word.format_map(Folders(here=_HERE)) for word in words]


def _end(process):
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process_tree.wait_or_kill(process, _END_S)


def _has_clock(path):
    """Set ROS_MASTER_URI to what the file says; return whether the simulator is on that master.

    A second roslaunch that starts earlier would start a master of its own.
    """
    with open(path) as file:
        os.environ['ROS_MASTER_URI'] = file.read().strip()
    try:
        topics = rosgraph.Master('/manual').getTopicTypes()
    except OSError:
        return False
    return any(name == '/clock' for name, _ in topics)


@contextlib.contextmanager
def simulator(words):
    """Run the demo without camera and recognition, on a master that it chooses."""
    demo = subprocess.Popen([
        sys.executable, os.path.join(_ROOT, 'tools', 'demo.py'),
        os.path.join(_ROOT, 'launch', 'demo.launch'), 'vision:=false',
        'robot_state_publisher:=false', 'respawn:=false', *words],
        preexec_fn=process_tree.end_with_parent)
    try:
        # demo.py writes it when it has chosen
        path = os.path.join(_ROOT, 'build', 'master.{}'.format(demo.pid))
        end = time.monotonic() + _START_S
        while not (os.path.exists(path) and os.path.getsize(path) and _has_clock(path)):
            if demo.poll() is not None or time.monotonic() > end:
                raise UserError(message('the simulator has not started'),
                                message('see what it has printed above'))
            time.sleep(0.1)
        yield
    finally:
        _end(demo)


@contextlib.contextmanager
def launched(chapter, words):
    """Run the launch file of a chapter; yield its process."""
    command = ['roslaunch', *filled(chapter.launch), *words]
    say(' '.join(command))
    process = subprocess.Popen(command, env=dict(os.environ, TURTLEBOT3_MODEL='burger'),
                               preexec_fn=process_tree.end_with_parent)
    try:
        yield process
    finally:
        _end(process)


def own_words(given):
    """Return the words for roslaunch that are not the same each time."""
    if given.chapter == 'autorace':
        has_plugin = 'compressed_image_transport' in rospkg.RosPack().list()
        return ['republish:={}'.format(str(not has_plugin).lower())]
    words = ['open_rviz:={}'.format('true' if os.environ.get('DISPLAY') else 'false')]
    if given.chapter == 'navigation':
        path = os.path.join(os.path.abspath(given.dir), 'map.yaml')
        if not os.path.exists(path):
            raise UserError(message('there is no map {}', path),
                            message('make it: ./run manual slam'))
        words.append('map_file:=' + path)
    return words


def _count(text):
    if not text.isdigit() or not 0 < int(text) < 10 ** 6:
        raise argparse.ArgumentTypeError('got {}, allowed is a whole number from 1 to 999999'
                                         .format(text))
    return int(text)


def main(words=None):
    """Run a chapter; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='./run manual', description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument('chapter', choices=CHAPTERS, metavar='CHAPTER', help='\n'.join(
        '{}: {}'.format(name, chapter.summary) for name, chapter in CHAPTERS.items()))
    parser.add_argument('arguments', nargs='*', metavar='ARG:=VALUE',
                        help='of ./run demo, for example real_time_factor:=0.5')
    parser.add_argument('--dir', default=os.path.expanduser('~/.cache/img_recog/manual'),
                        help='folder of the map (default: %(default)s)')
    parser.add_argument('--goal', action='append', nargs=3, type=float,
                        metavar=('X', 'Y', 'YAW'),
                        help='of navigation, in m and rad; can be repeated')
    parser.add_argument('--steps', type=_count, default=50,
                        help='of dqn (default: %(default)s)')
    parser.add_argument('--stay', action='store_true', help='go on at the end until Ctrl-C')
    given = parser.parse_intermixed_args(words)
    chapter = CHAPTERS[given.chapter]
    try:
        check_packages(chapter)
        os.makedirs(given.dir, exist_ok=True)
        words = own_words(given)
        with contextlib.ExitStack() as running:
            running.enter_context(simulator([*filled(chapter.demo), *given.arguments]))
            from reader import Reader       # rospy reads ROS_MASTER_URI when it is loaded
            reader = Reader()
            if chapter.launch:
                process = running.enter_context(launched(chapter, words))
                reader.is_running = lambda: process.poll() is None
            is_good = TASKS[given.chapter](reader, given)
            if given.stay:
                say(message('done; Ctrl-C ends it'))
                signal.pause()
    except UserError as error:
        sys.stderr.write('[run] {}\n'.format(error))
        return 1
    except KeyboardInterrupt:
        return 130
    return 0 if is_good else 1


if __name__ == '__main__':
    sys.exit(main())
