#!/usr/bin/env python3
"""Simulate the TurtleBot3 burger in the place of Gazebo."""
import sys

from img_recog.nodes.pybullet_sim import main

if __name__ == '__main__':
    sys.exit(main())
