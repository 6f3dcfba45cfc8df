#!/usr/bin/env python3
"""Say what is wrong with the machine and the running system, and what to do."""
import os
import sys

try:
    from img_recog.processes.script import start
except ImportError:         # nothing is sourced: the package is beside this file
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(
        os.path.realpath(__file__))), 'src'))
    from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.doctor.doctor_job')
