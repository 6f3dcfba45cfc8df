#!/usr/bin/env python3
"""Run the node turtlebot3_teleop_keyboard: drive the robot by the keys of a terminal."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.teleop_key import main
    sys.exit(main())
