"""Speed of the simulator node, compared with PyBullet alone."""
import os
import sys
from statistics import median
from typing import Callable, Dict, Optional

import rosgraph
from ros_processes import Master, run_script, wait_for

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.dirname(HERE)
ROUNDS = 3
SECONDS = 5.0
STEPS_A_SECOND = 1000           # per second of simulated time: the step is 1 ms


def node(real_time_factor: float, watched: bool, env: Optional[Dict[str, str]] = None) -> dict:
    """Return what sample.py measures with a new simulator.

    watched: whether a subscriber to all topics runs too.
    """
    with Master() as master:
        server = rosgraph.Master('/bench', master_uri=master.env['ROS_MASTER_URI'])
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            server.setParam('/robot_description', file.read())
        server.setParam('/use_sim_time', True)
        server.setParam('/gazebo/real_time_factor', float(real_time_factor))
        process = master.start(
            sys.executable, os.path.join(PACKAGE, 'scripts', 'pybullet_sim.py'), '__name:=gazebo',
            env=env)
        if watched:
            master.start(sys.executable, os.path.join(HERE, 'watch_all.py'))
        wait_for(lambda: '/clock' in dict(server.getPublishedTopics('')), 'the simulator')
        return run_script('sample.py', SECONDS, process.pid, env=master.env)


CASES = (('free run, no subscriber', 0, False), ('free run, all topics subscribed', 0, True),
         ('real time, no subscriber', 1, False), ('real time, all topics subscribed', 1, True))


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * (1 + len(CASES))


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over several rounds. Each round measures everything.

    done: called after each measurement.
    """
    bare, cases = [], {case: [] for case in CASES}
    for _ in range(ROUNDS):
        bare.append(run_script('bare_loop.py', SECONDS))
        done()
        for case in CASES:
            cases[case].append(node(*case[1:]))
            done()
    rows = []
    for case, samples in cases.items():
        factor = median(sample['real_time_factor'] for sample in samples)
        # ratios within a round: if the machine is slow for a while, it is slow for both
        ratio = median(sample['real_time_factor'] * STEPS_A_SECOND / alone
                       for sample, alone in zip(samples, bare))
        rows.append({'case': case[0], 'steps_per_s': factor * STEPS_A_SECOND,
                     'real_time_factor': factor, 'of_bare_loop': ratio,
                     'cpu_share': median(sample['cpu_share'] for sample in samples)})
    return {'bare_loop_steps_per_s': median(bare), 'node': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:34} {:>10} {:>10} {:>12} {:>10}'.format(
        'simulator in turtlebot3_world', 'steps/s', 'real time', 'of the bare', 'CPU of'),
        '{:34} {:>10} {:>10} {:>12} {:>10}'.format('', '', 'factor', 'loop', 'a core')]
    lines.append('{:34} {:10.0f} {:10.1f} {:>12}'.format(
        'bare loop of stepSimulation', results['bare_loop_steps_per_s'],
        results['bare_loop_steps_per_s'] / STEPS_A_SECOND, '1'))
    for row in results['node']:
        lines.append('{case:34} {steps_per_s:10.0f} {real_time_factor:10.2f} '
                     '{of_bare_loop:12.2f} {cpu_share:10.1%}'.format(**row))
    return '\n'.join(lines)
