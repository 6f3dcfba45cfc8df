#!/usr/bin/env python3
"""Simulate the TurtleBot3 burger in the place of Gazebo."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.gazebo.node import main
    sys.exit(main())
