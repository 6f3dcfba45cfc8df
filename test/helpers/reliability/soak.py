"""Soak: a demo that runs for a long time must not use more and more."""
import statistics
import time
from typing import Dict, List, NamedTuple

from img_recog_helpers.process_table import Usage
from img_recog_helpers.reliability import demo as demos
from img_recog_helpers.reliability.demo import LIMIT_S, NODES, Demo

_SAMPLE_S = 1.0
_CHECK_SHARE = 10           # the chain is checked after so many samples
# from the second quarter of the samples to the last one; connections of the master come and go
MAX_EXTRA = {'rss_mb': 10.0, 'threads': 2, 'descriptors': 2}


class Soak(NamedTuple):
    """What each node used early and late, and the times in which the chain answered."""

    early: Dict[str, Usage]
    late: Dict[str, Usage]
    chain_s: List[float]


def run(duration_s: float, factor: float = 1.0) -> Soak:
    """Run a demo and observe it; raise AssertionError if it fails or uses more and more."""
    with demos.running(factor) as demo:
        return observe(demo, duration_s, factor)


def observe(demo: Demo, duration_s: float, factor: float = 1.0) -> Soak:
    """Check a running demo; raise AssertionError if it fails or uses more and more."""
    samples: Dict[str, List[Usage]] = {name: [] for name in NODES}
    chain_s: List[float] = []
    pids = {name: demo.pid(name) for name in NODES}
    end, count = time.monotonic() + duration_s, 0
    while time.monotonic() < end:
        if count % _CHECK_SHARE == 0:
            chain_s.append(demo.chain.wait(LIMIT_S * factor).recovered_s)
        count += 1
        time.sleep(_SAMPLE_S)
        for name, used in demo.usage().items():
            samples[name].append(used)
    assert pids == {name: demo.pid(name) for name in NODES}, 'a node was started again'
    quarter = max(1, min(map(len, samples.values())) // 4)
    early = {name: _medians(each[quarter:2 * quarter] or each) for name, each in samples.items()}
    late = {name: _medians(each[-quarter:]) for name, each in samples.items()}
    problems = demos.problems(early, late, MAX_EXTRA)
    assert not problems, problems
    return Soak(early, late, chain_s)


def _medians(samples: List[Usage]) -> Usage:
    return Usage(*map(statistics.median, zip(*samples)))
