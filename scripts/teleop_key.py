#!/usr/bin/env python3
"""Drive the robot with the keys of a terminal."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.teleop_key import main
    sys.exit(main())
