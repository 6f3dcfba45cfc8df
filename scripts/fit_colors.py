#!/usr/bin/env python3
"""Find the bounds of colors that separate them best in recordings."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.batch.fit_job')
