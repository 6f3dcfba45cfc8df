#!/usr/bin/env python3
"""Show why a color is recognized in an image, or why not."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.tune_colors.cli import main
    sys.exit(main())
