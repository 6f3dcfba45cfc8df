#!/usr/bin/env python3
"""Simulate a world as fast as it goes and print it as lines of JSON, without a ROS master."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.checks.check_jobs', 'simulate.py')
