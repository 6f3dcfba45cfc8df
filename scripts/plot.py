#!/usr/bin/env python3
"""Draw a drive of a bag, or of the running system, as replay.py does."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.replay.plot_job')
