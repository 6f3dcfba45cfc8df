"""What several robots in one simulator cost, and how many of them run in real time."""
import json
import os
import sys
from statistics import median
from typing import Callable, Dict, List, NamedTuple

from ros_processes import HERE, Master, run_script, wait_for

PACKAGE = os.path.dirname(HERE)
NUMBERS = (1, 2, 4, 8, 16)
ROUNDS = 3
SECONDS = 5.0
STEPS_A_SECOND = 1000
TOPICS = ('imu', 'joint_states', 'odom', 'scan')
CAMERA = {'camera_frame': 'camera_link', 'camera_image_topic': 'usb_cam/image_raw',
          'camera_info_topic': 'usb_cam/camera_info', 'camera_width': 320, 'camera_height': 240,
          'camera_rate': 15.0}


class Case(NamedTuple):
    """How the robots run. factor: that is wanted, 0 is as fast as possible."""

    title: str
    factor: float
    is_watched: bool = False
    has_cameras: bool = False


CASES = (Case('free run, no subscriber', 0.0),
         Case('free run, all topics subscribed', 0.0, is_watched=True),
         Case('real time, all topics subscribed', 1.0, is_watched=True),
         Case('real time, camera 320x240 at 15 Hz and color_extract each', 1.0, has_cameras=True))


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * len(NUMBERS) * len(CASES)


def measure(done: Callable[[], None]) -> List[dict]:
    """Return the medians over all rounds; each round measures everything.

    done: called after each measurement.
    """
    found: Dict[tuple, List[dict]] = {}
    for _ in range(ROUNDS):
        for case in CASES:
            for number in NUMBERS:
                found.setdefault((case, number), []).append(_sample(case, number))
                done()
    return [{'case': case.title, 'robots': number,
             **{key: median(each[key] for each in samples) for key in samples[0]}}
            for (case, number), samples in found.items()]


def _sample(case: Case, number: int) -> dict:
    """Return what fleet_sample.py measures with a new simulator."""
    robots = ['tb3_{}'.format(index) for index in range(number)]
    with Master() as master:
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            master.server.setParam('/robot_description', file.read())
        master.server.setParam('/use_sim_time', True)
        master.server.setParam('/gazebo', {
            'real_time_factor': case.factor, 'several_robots': True,
            'robots': {robot: CAMERA if case.has_cameras else {} for robot in robots}})
        pids = [_script(master, 'pybullet_sim.py', '__name:=gazebo')]
        if case.is_watched:
            master.start(sys.executable, os.path.join(HERE, 'watch_topics.py'), '/clock', '/tf',
                         *('/{}/{}'.format(robot, topic) for robot in robots for topic in TOPICS))
        if case.has_cameras:
            pids += [_script(master, 'color_img_recog.py', '__ns:=/' + robot)
                     for robot in robots]
            wait_for(lambda: {'/{}/cmd_vel'.format(robot) for robot in robots}
                     <= {topic for topic, _ in master.server.getSystemState()[0]},
                     'the nodes color_extract')
        wait_for(lambda: '/clock' in dict(master.server.getPublishedTopics('')), 'the simulator')
        sample = run_script('fleet_sample.py', SECONDS, json.dumps(pids), *robots,
                            env=master.env)
    steps_a_second = sample['real_time_factor'] * STEPS_A_SECOND
    return {**sample, 'steps_per_s': steps_a_second,
            'robot_step_us': 1e6 * sample['cpu_share'] / steps_a_second / number}


def _script(master: Master, name: str, argument: str) -> int:
    """Start a script of the package; return its process id."""
    return master.start(sys.executable, os.path.join(PACKAGE, 'scripts', name), argument).pid


def table(results: List[dict]) -> str:
    """Return the results as a table."""
    lines = ['{:60} {:>6} {:>8} {:>10} {:>8} {:>13} {:>10}'.format(*titles) for titles in (
        ('several robots in turtlebot3_world', 'robots', 'steps/s', 'real time', 'CPU of',
         'CPU of a step', 'memory of'),
        ('', '', '', 'factor', 'a core', 'a robot, us', 'all, MB'))]
    lines += ['{case:60} {robots:6d} {steps_per_s:8.0f} {real_time_factor:10.2f} '
              '{cpu_share:8.1%} {robot_step_us:13.1f} {memory_mb:10.0f}'.format(**row)
              for row in results]
    return '\n'.join(lines)
