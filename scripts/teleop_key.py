#!/usr/bin/env python3
"""Drive the robot with the keys of a terminal."""
import sys

from img_recog.nodes.teleop_key import main

if __name__ == '__main__':
    sys.exit(main())
