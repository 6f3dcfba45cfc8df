"""What all tests need."""
import gc

from img_recog_helpers.signals import handle_ignored_signals

_LONGEST_ID = 80


def pytest_configure():
    handle_ignored_signals()


def pytest_collection_finish():
    # to look through what stays until the end again and again takes 4 % of the unit tests' time
    gc.freeze()


def pytest_make_parametrize_id(val, argname):
    """Name a test by a long value's argument: a hostile input of 1 MB is no name for a report."""
    return argname if isinstance(val, (str, bytes)) and len(val) > _LONGEST_ID else None
