"""Speed of the simulator node, compared with PyBullet alone."""
import os
import sys
from statistics import median
from typing import Callable, Dict, Optional, Sequence

from ros_processes import Master, run_script, wait_for

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.dirname(HERE)
ROUNDS = 3
TURNS, SECONDS = 5, 1.0         # in a round; a turn is once of the simulator and once of PyBullet
STEPS_A_SECOND = 1000           # per second of simulated time: the step is 1 ms
# messages per second of simulated time
RATES_HZ = {'/clock': 100, '/imu': 200, '/joint_states': 30, '/odom': 30, '/scan': 5, '/tf': 30}


def node(real_time_factor: float, topics: Sequence[str], env: Optional[Dict[str, str]] = None
         ) -> dict:
    """Return the medians of what sample.py measures with a new simulator.

    topics: a subscriber to these runs too. step_us: the CPU time of a step; of_bare_loop: in free
    run, the ratio of the steps per second in the same turn.
    """
    with Master() as master:
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            master.server.setParam('/robot_description', file.read())
        master.server.setParam('/use_sim_time', True)
        master.server.setParam('/gazebo/real_time_factor', float(real_time_factor))
        process = master.start(
            sys.executable, os.path.join(PACKAGE, 'scripts', 'pybullet_sim.py'), '__name:=gazebo',
            env=env)
        if topics:
            master.start(sys.executable, os.path.join(HERE, 'watch_topics.py'), *topics)
        wait_for(lambda: '/clock' in dict(master.server.getPublishedTopics('')), 'the simulator')
        samples = run_script('sample.py', process.pid, TURNS, SECONDS, int(not real_time_factor),
                             env=master.env)
    for sample in samples:
        steps_per_s = sample['real_time_factor'] * STEPS_A_SECOND
        sample['step_us'] = 1e6 * sample['cpu_share'] / steps_per_s
        if 'bare_steps_per_s' in sample:
            sample['of_bare_loop'] = steps_per_s / sample['bare_steps_per_s']
    return {key: median(sample[key] for sample in samples) for key in samples[0]}


def _cases() -> list:
    """Return the cases: title, real time factor, topics that are subscribed."""
    everything = tuple(RATES_HZ)
    free, paced = 'free run, ', 'real time, '
    return [(free + 'no subscriber', 0, ()), (free + 'all topics subscribed', 0, everything),
            *((free + topic, 0, (topic,)) for topic in RATES_HZ),
            (paced + 'no subscriber', 1, ()), (paced + 'all topics subscribed', 1, everything)]


CASES = _cases()


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * len(CASES)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over several rounds. Each round measures everything.

    done: called after each measurement.
    """
    cases: Dict[tuple, list] = {case: [] for case in CASES}
    for _ in range(ROUNDS):
        for case in CASES:
            cases[case].append(node(*case[1:]))
            done()
    rows = []
    idle = cases[CASES[0]]
    for case, samples in cases.items():
        title, wanted_factor, topics = case
        factor = median(sample['real_time_factor'] for sample in samples)
        row = {'case': title, 'steps_per_s': factor * STEPS_A_SECOND, 'real_time_factor': factor,
               'cpu_share': median(sample['cpu_share'] for sample in samples),
               'step_us': median(sample['step_us'] for sample in samples)}
        if not wanted_factor:
            row['of_bare_loop'] = median(sample['of_bare_loop'] for sample in samples)
        if len(topics) == 1 and not wanted_factor:
            row['message_us'] = median(
                (sample['step_us'] - without['step_us']) * STEPS_A_SECOND / RATES_HZ[topics[0]]
                for sample, without in zip(samples, idle))
        rows.append(row)
    return {'bare_loop_steps_per_s': median(
        sample['bare_steps_per_s'] for samples in cases.values() for sample in samples
        if 'bare_steps_per_s' in sample), 'node': rows}


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
