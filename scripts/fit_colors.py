#!/usr/bin/env python3
"""Find the bounds of colors that separate them best in recordings."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.batch.fit_job import main
    sys.exit(main())
