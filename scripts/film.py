#!/usr/bin/env python3
"""Make a film of a bag that was recorded in the running system."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.replay.film_job import main
    sys.exit(main())
