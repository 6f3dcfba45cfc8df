#!/usr/bin/env python3
"""Say what has taken the place of this program, which is removed in the next release."""
import sys

if __name__ == '__main__':
    sys.stderr.write('tune_colors.py is no longer here; use fit_colors.py for bounds with pictures '
                     'that show why (doc/fitting.md), and rqt_reconfigure or the tab Colors of the '
                     'page for sliders\n')
    sys.exit(2)
