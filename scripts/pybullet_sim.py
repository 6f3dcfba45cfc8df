#!/usr/bin/env python3
"""Run the node gazebo: simulate the TurtleBot3 burger with PyBullet instead of Gazebo."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.gazebo.node import main
    sys.exit(main())
