#!/usr/bin/env python3
"""Draw the nodes and topics of the running system to a file."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.graph.graph_job import main
    sys.exit(main())
