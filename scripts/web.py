#!/usr/bin/env python3
"""Start the node web: a page that shows the system and drives the robot."""
import os
import signal
import sys

NICENESS = 5

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    # the nodes that the robot needs come first, also while this one loads its modules for 2 s
    os.nice(NICENESS)
    from img_recog.nodes.web.node import main
    sys.exit(main())
