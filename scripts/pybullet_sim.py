#!/usr/bin/env python3
"""Run the node gazebo: simulate the TurtleBot3 burger with PyBullet instead of Gazebo."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.nodes.gazebo.gazebo_node')
