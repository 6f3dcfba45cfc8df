#!/usr/bin/env python3
"""Run a video or a bag through recognition and simulation, without a ROS master."""
import time

from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.replay.job', time.perf_counter(), one_thread=True)
