#!/usr/bin/env python3
"""Run thousands of closed loops of a camera on the simulated robot, without a ROS master."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.batch.sweep_job', one_thread=True)
