#!/usr/bin/env python3
"""Run the node turtlebot3_teleop_keyboard: drive the robot by the keys of a terminal."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.nodes.teleop_key')
