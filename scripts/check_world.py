#!/usr/bin/env python3
"""Say what of a world file is simulated, without a ROS master."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.checks.check_jobs', 'check_world.py')
