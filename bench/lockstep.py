"""Simulated time that waits for the node of a user, beside time that does not."""
import os
import sys
import time
from statistics import median
from typing import Callable

from ros_processes import HERE, Master, run_script

ROUNDS, SECONDS = 3, 20.0
CASES = (('without lockstep', ()), ('lockstep', ('lockstep:=cmd_vel',)))


def run(arguments: tuple) -> dict:
    """Return what lockstep_sample.py measures, and the time from the start of roslaunch on."""
    begin_s = time.monotonic()
    with Master() as master:
        master.start('roslaunch', 'img_recog', 'demo.launch', 'camera:=robot',
                     'world:=color_posts',
                     'recognition:=false', 'teleop:=false', 'gui:=false', 'image_view:=false',
                     'web:=false', 'real_time_factor:=0', *arguments)
        # as the launch file of templates/my_robot_vision starts a node
        master.start(sys.executable, os.path.join(HERE, 'follower_node.py'),
                     env={'OPENCV_FOR_THREADS_NUM': '1'})
        found = run_script('lockstep_sample.py', SECONDS, env=master.env)
    return dict(found, whole_s=time.monotonic() - begin_s)


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * len(CASES)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over several rounds, in pairs; done: called after each measurement."""
    samples: dict = {name: [] for name, _ in CASES}
    for _ in range(ROUNDS):
        for name, arguments in CASES:
            samples[name].append(run(arguments))
            done()
    rows = [dict({key: median(each[key] for each in found)
                  for key in ('wall_s', 'whole_s', 'commands')},
                 case=name, paths=len({each['path'] for each in found}))
            for name, found in samples.items()]
    ratios = [with_it['wall_s'] / without['wall_s']
              for without, with_it in zip(*samples.values())]
    return {'rows': rows, 'ratio': median(ratios)}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:36} {:>8} {:>12} {:>9} {:>16}'.format(
        '20 simulated s, 640x480 at 30 Hz', 'wall', 'with start', 'commands', 'different paths')]
    for row in results['rows']:
        lines.append('{case:36} {wall_s:6.1f} s {whole_s:10.1f} s {commands:9.0f} {paths:9} of {}'
                     .format(ROUNDS, **row))
    return '\n'.join(lines + ['ratio of the wall times, paired: {ratio:.2f}'.format(**results)])
