"""What all tests need."""
from img_recog_testing.signals import handle_ignored_signals


def pytest_configure():
    handle_ignored_signals()
