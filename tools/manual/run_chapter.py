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
from chapters import CHAPTERS, GOALS, PILLAR_RADIUS, PILLARS, START

from img_recog import process_tree
from img_recog.errors import UserError

_ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
_NOETIC = '/opt/ros/noetic'
_START_S, _END_S = 60.0, 20.0


def say(text):
    """Print a line of ./run."""
    sys.stdout.write('[run] {}\n'.format(text))
    sys.stdout.flush()


def check_packages(chapter):
    """Raise UserError if a package of ROS that the chapter needs is missing."""
    known = set(rospkg.RosPack().list())
    missing = [name for name in chapter.packages if name not in known]
    if not missing:
        return
    raise UserError(
        'these packages of ROS are missing: {}'.format(' '.join(missing)),
        'install {}'.format(' '.join(chapter.noetic)) if os.path.isdir(_NOETIC) else
        'Debian has none of them: source the setup.bash of a workspace that has them before '
        './run; see doc/manual.md')


def _end(process):
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()


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
                raise UserError('the simulator has not started', 'see what it has printed above')
            time.sleep(0.1)
        yield
    finally:
        _end(demo)


@contextlib.contextmanager
def launched(chapter, words):
    """Run the launch file of the chapter; yield its process."""
    command = ['roslaunch', *chapter.launch, *words,
               'open_rviz:={}'.format('true' if os.environ.get('DISPLAY') else 'false')]
    say(' '.join(command))
    process = subprocess.Popen(command, env=dict(os.environ, TURTLEBOT3_MODEL='burger'),
                               preexec_fn=process_tree.end_with_parent)
    try:
        yield process
    finally:
        _end(process)


def slam(reader, folder):
    """Drive round, save the map, and return whether all pillars are in it, within one cell."""
    import occupancy
    say('driving round along the wall, about 2 min')
    reader.explore()
    grid = reader.grid()
    path = os.path.join(folder, 'map')
    occupancy.save(grid, path)
    found = occupancy.find_pillars(grid, PILLARS, PILLAR_RADIUS)
    say('the map is in {0}.yaml and {0}.pgm'.format(path))
    say('{} of {} pillars are in the map'.format(len(found), len(PILLARS)))
    if len(found) < len(PILLARS):
        return False
    for error, name in zip(occupancy.errors(found), ('in the frame of the world',
                                                     'in the frame of the map')):
        say('{}, their centers are off by at most {:.3f} m, {:.2f} cells'.format(
            name, error, error / grid.resolution))
    return error <= grid.resolution


def navigation(reader, goals):
    """Drive to the goals; return whether move_base says that all were reached."""
    reader.localize(START)
    is_good = True
    for goal in goals:
        text, error_m, time_s = reader.drive_to(goal)
        say('goal {:g} {:g}: {} after {:.0f} s, {:.3f} m from it'.format(
            goal[0], goal[1], text, time_s, error_m))
        is_good = is_good and text == 'reached'
    return is_good


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
    parser.add_argument('--stay', action='store_true', help='go on at the end until Ctrl-C')
    given = parser.parse_intermixed_args(words)
    chapter, launch_words = CHAPTERS[given.chapter], []
    try:
        check_packages(chapter)
        os.makedirs(given.dir, exist_ok=True)
        if given.chapter == 'navigation':
            path = os.path.join(os.path.abspath(given.dir), 'map.yaml')
            if not os.path.exists(path):
                raise UserError('there is no map {}'.format(path), 'make it: ./run manual slam')
            launch_words = ['map_file:=' + path]
        with contextlib.ExitStack() as running:
            running.enter_context(simulator(given.arguments))
            from reader import Reader       # rospy reads ROS_MASTER_URI when it is loaded
            reader = Reader()
            process = running.enter_context(launched(chapter, launch_words))
            reader.is_running = lambda: process.poll() is None
            is_good = (slam(reader, given.dir) if given.chapter == 'slam'
                       else navigation(reader, given.goal or GOALS))
            if given.stay:
                say('done; Ctrl-C ends it')
                signal.pause()
    except UserError as error:
        sys.stderr.write('[run] {}\n'.format(error))
        return 1
    except KeyboardInterrupt:
        return 130
    return 0 if is_good else 1


if __name__ == '__main__':
    sys.exit(main())
