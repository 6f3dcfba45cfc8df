#!/usr/bin/env python3
"""Run thousands of closed loops of a camera on the simulated robot, without a ROS master."""
import os
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    # as many processes as cores; the matrices are too small for the threads of numpy to help
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from img_recog.batch.sweep_job import main
    sys.exit(main())
