"""Signals that the environment ignores."""
import signal


def handle_ignored_signals():
    """Handle, by doing nothing, what nohup and the `&` of a script ignore.

    Programs inherit what is ignored, but no handlers: what the tests start ends by signals, and
    the tests themselves go on.
    """
    for signum in (signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(signum) == signal.SIG_IGN:
            signal.signal(signum, lambda *_: None)
