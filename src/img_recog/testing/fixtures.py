"""A plugin of pytest with the fixture `simulation`.

Use it by this line in the topmost conftest.py:

    pytest_plugins = ['img_recog.testing.fixtures']
"""
import contextlib
from typing import Any, Callable, Iterator, Set

import pytest

from img_recog.testing import Simulation, evidence
from img_recog.testing.launching import of_reasons

__tracebackhide__ = of_reasons
_failed: Set[str] = set()       # the tests, while their fixtures end


def pytest_configure(config: Any) -> None:
    """Find the file for the results; have no warnings about rospy."""
    config.addinivalue_line('filterwarnings', r'ignore:notifyAll\(\):DeprecationWarning:rospy')
    evidence.results_file = config.getoption('xmlpath', None) or ''


def pytest_runtest_makereport(item: Any, call: Any) -> None:
    """Remember that a test has failed."""
    if call.when != 'teardown' and call.excinfo is not None and not call.excinfo.errisinstance(
            pytest.skip.Exception):
        _failed.add(item.nodeid)


@pytest.fixture
def simulation(request: Any) -> Iterator[Callable[..., Simulation]]:
    """Return a function that starts a Simulation, with its arguments.

    It ends with the test, or when the function is called again.
    """
    with contextlib.ExitStack() as stack:
        def end(running: Simulation) -> None:
            running.end(request.node.nodeid in _failed)

        def start(*args: Any, **kwargs: Any) -> Simulation:
            stack.close()
            running = Simulation(*args, **kwargs)
            running.start()
            stack.callback(end, running)
            return running
        yield start
    _failed.discard(request.node.nodeid)
