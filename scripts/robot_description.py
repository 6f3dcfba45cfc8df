#!/usr/bin/env python3
"""Print the URDF of a robot's file; a xacro file is expanded."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.checks.check_jobs', 'robot_description.py')
