#!/usr/bin/env python3
"""Run the node gazebo: simulate the TurtleBot3 burger with PyBullet instead of Gazebo."""
import gc
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    gc.disable()    # a tenth of the start: modules that load leave no garbage
    from img_recog.nodes.gazebo.gazebo_node import main
    gc.enable()
    sys.exit(main())
