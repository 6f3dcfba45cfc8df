#!/usr/bin/env python3
"""Run a video or a bag through recognition and simulation, without a ROS master."""
import os
import signal
import sys
import time

if __name__ == '__main__':
    begin_s = time.perf_counter()
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    # the matrices are too small for the threads of numpy to help
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from img_recog.replay.job import main
    sys.exit(main(begin_s))
