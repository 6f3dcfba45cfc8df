#!/usr/bin/env python3
"""Run the node color_extract: command the robot by the colors in images."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.color_extract.color_extract_node import main
    sys.exit(main())
