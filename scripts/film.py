#!/usr/bin/env python3
"""Make a film of a bag that was recorded in the running system."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.replay.film_job')
