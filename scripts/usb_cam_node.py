#!/usr/bin/env python3
"""Publish the frames of a camera, a film, a still image or the synthetic scene."""
import sys

from img_recog.nodes.usb_cam_node import main

if __name__ == '__main__':
    sys.exit(main())
