"""Signals are not ignored in the tests, nor in what they start."""
import signal


def pytest_configure():
    """Handle what nohup and the `&` of a script ignore: programs would inherit that.

    The tests themselves go on when such a signal comes.
    """
    for signum in (signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(signum) == signal.SIG_IGN:
            signal.signal(signum, lambda *_: None)
