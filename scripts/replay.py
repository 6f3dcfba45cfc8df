#!/usr/bin/env python3
"""Run a video or a bag through recognition and simulation, without a ROS master."""
import os
import time

from img_recog.processes.script import start

if __name__ == '__main__':
    begin_s = time.perf_counter()
    # the matrices are too small for the threads of numpy to help
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    start('img_recog.replay.job', begin_s)
