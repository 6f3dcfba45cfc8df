#!/usr/bin/env python3
"""Make a package with a node, its tests in the simulator, and files for CI, from a template."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.command_line.new_package import main
    sys.exit(main())
