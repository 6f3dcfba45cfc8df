"""Speed of the simulator node, beside a loop of PyBullet alone in the same turns."""
from typing import Dict, List, Optional, Sequence

from pairs import Benchmark, Column, Samples
from ros_processes import Master, run_script

TURNS, SECONDS = 10, 0.5        # in a round; a turn measures all ways
TOPICS = '/clock', '/imu', '/joint_states', '/odom', '/scan', '/tf'
ALL = {'all topics subscribed': TOPICS}
WAYS = {'no subscriber': (), **ALL}


def node(real_time_factor: float, ways: Dict[str, Sequence[str]],
         env: Optional[Dict[str, str]] = None) -> Samples:
    """Return what drive_sample.py measures with a new simulator; ways: topics to subscribe to."""
    with Master() as master:
        pid = master.start_simulator(env=env, real_time_factor=real_time_factor)
        turns: List[List[dict]] = run_script('drive_sample.py', {
            'robots': [''], 'pids': [pid], 'seconds': SECONDS, 'turns': TURNS,
            'subscribers': list(ways.values()), 'bare': not real_time_factor}, env=master.env)
    return {way: [turn[number] for turn in turns] for number, way in enumerate(ways)}


def benchmark() -> Benchmark:
    """Return how fast the node runs without a limit and in real time."""
    return Benchmark('simulator in turtlebot3_world', {
        'free run': lambda: node(0.0, {**WAYS, **{topic: (topic,) for topic in TOPICS}}),
        'real time': lambda: node(1.0, WAYS)}, (
            Column('steps/s', 'steps_per_s', '{:.0f}'), Column('real time', 'factor'),
            Column('of the bare loop', 'of_bare'), Column('its steps/s', 'bare', '{:.0f}'),
            Column('CPU of a core', 'cpu_share', '{:.1%}'),
            Column('CPU of a step, us', 'step_us', '{:.1f}')))
