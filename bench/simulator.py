"""Speed of the simulator node, compared with PyBullet alone."""
import json
import os
import sys
from statistics import median
from typing import Callable, Dict, List, Optional, Sequence

from ros_processes import Master, run_script, wait_for

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.dirname(HERE)
ROUNDS = 3                      # a new simulator in each
TURNS, SECONDS = 10, 0.5        # in a round; a turn measures all cases
STEPS_A_SECOND = 1000           # per second of simulated time: the step is 1 ms
# messages per second of simulated time
RATES_HZ = {'/clock': 100, '/imu': 200, '/joint_states': 30, '/odom': 30, '/scan': 5, '/tf': 30}
ALL, NONE = tuple(RATES_HZ), ()
# topics that are subscribed, by the title
CASES = {'no subscriber': NONE, 'all topics subscribed': ALL}
TOPICS = {topic: (topic,) for topic in RATES_HZ}


def node(real_time_factor: float, subscribers: Sequence[Sequence[str]],
         env: Optional[Dict[str, str]] = None) -> List[List[dict]]:
    """Return what sample.py measures with a new simulator, for each turn and its subscribers.

    subscribers: lists of topics. step_us: the CPU time of a step; in free run, of_bare_loop: the
    ratio of the steps per second to those of PyBullet alone at the same time.
    """
    with Master() as master:
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            master.server.setParam('/robot_description', file.read())
        master.server.setParam('/use_sim_time', True)
        master.server.setParam('/gazebo/real_time_factor', float(real_time_factor))
        process = master.start(
            sys.executable, os.path.join(PACKAGE, 'scripts', 'pybullet_sim.py'), '__name:=gazebo',
            env=env)
        wait_for(lambda: '/clock' in dict(master.server.getPublishedTopics('')), 'the simulator')
        turns = run_script('sample.py', process.pid, SECONDS, TURNS, json.dumps(subscribers),
                           int(not real_time_factor), env=master.env)
    for sample in (sample for turn in turns for sample in turn):
        sample['steps_per_s'] = sample['real_time_factor'] * STEPS_A_SECOND
        sample['step_us'] = 1e6 * sample['cpu_share'] / sample['steps_per_s']
        if 'bare_steps_per_s' in sample:
            sample['of_bare_loop'] = sample['steps_per_s'] / sample['bare_steps_per_s']
    return turns


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return 2 * ROUNDS


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over all turns of several rounds.

    done: called after each measurement.
    """
    rows: List[dict] = []
    bare: List[float] = []
    for mode, factor, cases in (('free run', 0.0, {**CASES, **TOPICS}), ('real time', 1.0, CASES)):
        turns: List[List[dict]] = []
        for _ in range(ROUNDS):
            turns += node(factor, list(cases.values()))
            done()
        for number, title in enumerate(cases):
            samples = [turn[number] for turn in turns]
            row = {'case': '{}, {}'.format(mode, title),
                   **{key: median(each[key] for each in samples) for key in samples[0]}}
            if title in TOPICS:
                # in the same turn: if the machine is slow for a while, it is slow for both
                row['message_us'] = median(
                    (turn[number]['step_us'] - turn[0]['step_us'])
                    * STEPS_A_SECOND / RATES_HZ[title] for turn in turns)
            rows.append(row)
        bare += [each['bare_steps_per_s'] for turn in turns for each in turn
                 if 'bare_steps_per_s' in each]
    return {'bare_loop_steps_per_s': median(bare), 'node': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:34} {:>8} {:>10} {:>12} {:>8} {:>9} {:>11}'.format(*titles) for titles in (
        ('simulator in turtlebot3_world', 'steps/s', 'real time', 'of the bare', 'CPU of',
         'CPU of a', 'of a'), ('', '', 'factor', 'loop', 'a core', 'step, us', 'message, us'))]
    bare = results['bare_loop_steps_per_s']
    lines.append('{:34} {:8.0f} {:10.1f} {:>12} {:>8} {:9.1f}'.format(
        'bare loop of stepSimulation', bare, bare / STEPS_A_SECOND, '1', '', 1e6 / bare))
    for row in results['node']:
        ratio = '{:.2f}'.format(row['of_bare_loop']) if 'of_bare_loop' in row else ''
        line = ('{case:34} {steps_per_s:8.0f} {real_time_factor:10.2f} {ratio:>12} '
                '{cpu_share:8.1%} {step_us:9.1f}').format(ratio=ratio, **row)
        if 'message_us' in row:
            line += ' {message_us:11.0f}'.format(**row)
        lines.append(line)
    return '\n'.join(lines)
