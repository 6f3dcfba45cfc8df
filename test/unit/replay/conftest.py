"""What several tests of the replay and of films need."""
import signal

import pytest


@pytest.fixture
def handlers_as_before():
    """Set the handlers of signals that end a program as they were, after the test."""
    before = {signum: signal.getsignal(signum)
              for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for signum, handler in before.items():
        signal.signal(signum, handler)
