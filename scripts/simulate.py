#!/usr/bin/env python3
"""Simulate a world as fast as it goes and print it as lines of JSON, without a ROS master."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.checks.check_jobs import simulate
    sys.exit(simulate())
