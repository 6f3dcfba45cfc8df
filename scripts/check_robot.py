#!/usr/bin/env python3
"""Say what of a robot file is simulated, without a ROS master."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.checks.check_jobs import robot
    sys.exit(robot())
