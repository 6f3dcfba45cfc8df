#!/usr/bin/env python3
"""Make a package with a node, its tests in the simulator, and files for CI, from a template."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.command_line.new_package')
