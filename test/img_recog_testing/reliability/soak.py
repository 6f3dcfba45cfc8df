"""Soak: a demo that runs for a long time must not use more and more."""
import statistics
import time
from typing import Dict, List, NamedTuple

from img_recog_testing.process_table import Usage
from img_recog_testing.reliability import demo as demos
from img_recog_testing.reliability.demo import LIMIT_S, NODES, Demo

_SAMPLE_S = 1.0
_CHECK_SHARE = 10           # the chain is checked after so many samples
# from the second quarter of the samples to the last one
MAX_GROWTH_MB = 10.0
MAX_EXTRA = 2       # threads or descriptors: connections of the master come and go


class Growth(NamedTuple):
    """Medians of the second and of the last quarter of the samples of one node."""

    rss_mb: float
    rss_growth_mb: float
    threads: int
    threads_growth: int
    descriptors: int
    descriptors_growth: int


class Soak(NamedTuple):
    """How much each node uses, and the times in which the chain answered."""

    growth: Dict[str, Growth]
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
    growth = {name: _growth(each) for name, each in samples.items()}
    problems = {name: each for name, each in growth.items()
                if each.rss_growth_mb > MAX_GROWTH_MB or each.threads_growth > MAX_EXTRA
                or each.descriptors_growth > MAX_EXTRA}
    assert not problems, problems
    return Soak(growth, chain_s)


def _growth(samples: List[Usage]) -> Growth:
    quarter = max(1, len(samples) // 4)
    early, late = samples[quarter:2 * quarter] or samples, samples[-quarter:]
    values: List[float] = []
    for name in ('rss_mb', 'threads', 'descriptors'):
        begin, end = (statistics.median(getattr(each, name) for each in part)
                      for part in (early, late))
        values += [end, end - begin]
    return Growth(*(round(value, 1) if index < 2 else int(value)
                    for index, value in enumerate(values)))
