#!/usr/bin/env python3
"""Run a video or a bag through recognition and simulation, without a ROS master."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.replay.main import main
    sys.exit(main())
