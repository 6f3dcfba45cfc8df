#!/usr/bin/env python3
"""Compare sets of colors in many recordings, without a ROS master."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.batch.evaluate_job', one_thread=True)
