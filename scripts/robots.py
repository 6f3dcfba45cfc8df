#!/usr/bin/env python3
"""Start the node robots: several robots in one world, each with its nodes in its namespace."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.nodes.robots.robots_node')
