#!/usr/bin/env python3
"""Compare sets of colors in many recordings, without a ROS master."""
import os

from img_recog.processes.script import start

if __name__ == '__main__':
    # as many processes as cores; the matrices are too small for the threads of numpy to help
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    start('img_recog.batch.evaluate_job')
