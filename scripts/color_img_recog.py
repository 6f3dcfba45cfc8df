#!/usr/bin/env python3
"""Run the node color_extract: command the robot by the colors in images."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.nodes.color_extract.color_extract_node')
