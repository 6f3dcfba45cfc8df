#!/usr/bin/env python3
"""Run a node that compresses images or decompresses them, like republish of image_transport."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.republish import main
    sys.exit(main())
