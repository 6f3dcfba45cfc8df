#!/usr/bin/env python3
"""Start the node web."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.web.node import main
    sys.exit(main())
