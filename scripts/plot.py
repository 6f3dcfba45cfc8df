#!/usr/bin/env python3
"""Draw a drive of a bag, or of the running system, as replay.py does."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.replay.plot_job import main
    sys.exit(main())
