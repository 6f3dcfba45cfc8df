#!/usr/bin/env python3
"""Start the node web: a page that shows the system and drives the robot."""
import contextlib
import os
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    # loading takes 2 s of CPU time, while the nodes that the robot needs start too
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    from img_recog.nodes.web.node import main
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    sys.exit(main())
