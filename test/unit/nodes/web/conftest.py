"""A fixture for tests of what runs in threads."""
import threading

import pytest

from img_recog_helpers.waiting import wait_for


@pytest.fixture
def wait_for_threads():
    """A function that waits for the end of the threads that the test has started."""
    before = set(threading.enumerate())
    return lambda: wait_for(lambda: set(threading.enumerate()) <= before, 'the end of the threads')
