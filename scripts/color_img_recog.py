#!/usr/bin/env python3
"""Recognise colours in images and command the robot."""
import sys

from img_recog.nodes.color_img_recog import main

if __name__ == '__main__':
    sys.exit(main())
