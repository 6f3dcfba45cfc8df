#!/usr/bin/env python3
"""Publish the frames of a camera, a video, an image or the synthetic scene."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.usb_cam.node import main
    sys.exit(main())
