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
from chapters import CHAPTERS, GOAL_RADIUS, GOALS, PILLAR_RADIUS, PILLARS, START

from img_recog import process_tree
from img_recog.errors import UserError
from img_recog.messages import message

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
        message('these packages of ROS are missing: {}', ' '.join(missing)),
        message('install {}', ' '.join(chapter.noetic)) if os.path.isdir(_NOETIC) else
        message('Debian has none of them: source the setup.bash of a workspace that has them '
                'before ./run; see doc/manual.md'))


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
    say(message('driving round along the wall, about 2 min'))
    reader.explore()
    grid = reader.grid()
    path = os.path.join(folder, 'map')
    occupancy.save(grid, path)
    found = occupancy.find_pillars(grid, PILLARS, PILLAR_RADIUS)
    say(message('the map is in {}.yaml and {}.pgm', path, path))
    say(message('{} of {} pillars are in the map', len(found), len(PILLARS)))
    if len(found) < len(PILLARS):
        return False
    in_world, in_map = occupancy.errors(found)
    say(message('in the frame of the world, their centers are off by at most {} m, {} cells',
                *_figures(in_world, grid)))
    say(message('in the frame of the map, their centers are off by at most {} m, {} cells',
                *_figures(in_map, grid)))
    return in_map <= grid.resolution


def _figures(error_m, grid):
    return '{:.3f}'.format(error_m), '{:.2f}'.format(error_m / grid.resolution)


def navigation(reader, goals):
    """Drive to the goals; return whether the robot came near all of them, and so move_base says.

    Near is GOAL_RADIUS, at its true position.
    """
    reader.localize(START)
    is_good = True
    for goal in goals:
        end = reader.drive_to(goal)
        say(message('goal {} {}: {} after {} s, {} m from it', *goal[:2], end.text,
                    '{:.0f}'.format(end.time_s), '{:.3f}'.format(end.error_m)))
        if end.is_reached and end.error_m > GOAL_RADIUS:
            say(message('that is too far: at most {} m are allowed', GOAL_RADIUS))
        is_good = is_good and end.is_reached and end.error_m <= GOAL_RADIUS
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
                raise UserError(message('there is no map {}', path),
                                message('make it: ./run manual slam'))
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
