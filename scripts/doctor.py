#!/usr/bin/env python3
"""Say what is wrong with the machine and the running system, and what to do."""
import os
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    try:
        from img_recog.doctor.doctor_job import main
    except ImportError:         # nothing is sourced: the package is beside this file
        sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(
            os.path.realpath(__file__))), 'src'))
        from img_recog.doctor.doctor_job import main
    sys.exit(main())
