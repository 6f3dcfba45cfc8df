#!/usr/bin/env python3
"""Say what has taken the place of this program, which is removed in the next release."""
import argparse
import sys

TEXT = ('it is no longer here; use fit_colors.py for bounds and pictures that show why, and the '
        'page or rqt_reconfigure for sliders')

if __name__ == '__main__':
    argparse.ArgumentParser(prog='tune_colors.py', description=TEXT).parse_known_args()
    sys.stderr.write('tune_colors.py: {}\n'.format(TEXT))
    sys.exit(2)
