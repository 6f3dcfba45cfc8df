#!/usr/bin/env python3
"""Say what has taken the place of this program, which is removed in the next release."""
import sys

if __name__ == '__main__':
    sys.stderr.write('tune_colors.py is no longer here; use fit_colors.py for bounds and pictures '
                     'that show why, and the page or rqt_reconfigure for sliders\n')
    sys.exit(2)
