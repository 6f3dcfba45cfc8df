#!/usr/bin/env python3
"""Writes Python modules of gazebo_msgs to a folder, unless it is installed.

Usage: gazebo_msgs_stand_in.py FOLDER, from a launch file: before it starts the nodes.
"""
import os
import pathlib
import sys

from img_recog_helpers import gazebo_messages

if __name__ == '__main__':
    if not gazebo_messages.INSTALLED:
        folder = pathlib.Path(sys.argv[1])
        # the generator writes what it does to the standard output, which is the parameter's value
        with open(os.devnull, 'w') as sys.stdout:
            gazebo_messages.write_package(folder)
