#!/usr/bin/env python3
"""Print the URDF of a robot's file; a xacro file is expanded."""
import sys

if __name__ == '__main__':
    from img_recog.checks.check_jobs import robot_description
    sys.exit(robot_description())
