"""Simulated time that waits for the node of a user, beside time that does not."""
import os
import sys
import time

from pairs import Benchmark, Column
from ros_processes import HERE, Master, run_script

SECONDS = 20.0
WAYS = {'without lockstep': (), 'lockstep': ('lockstep:=cmd_vel',)}


def _run(arguments: tuple) -> dict:
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


def benchmark() -> Benchmark:
    """Return how long simulated time takes."""
    return Benchmark('20 simulated s, 640x480 at 30 Hz', {
        '': lambda: {name: [_run(arguments)] for name, arguments in WAYS.items()}}, (
            Column('wall', 'wall_s', '{:.1f} s', has_ratio=True),
            Column('with start', 'whole_s', '{:.1f} s'),
            Column('commands', 'commands', '{:.0f}')))
