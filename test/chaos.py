#!/usr/bin/env python3
"""Break parts of a running demo at random; ./run chaos --help describes it."""
import sys

from img_recog_testing.reliability.chaos import main

if __name__ == '__main__':
    sys.exit(main())
