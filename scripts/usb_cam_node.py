#!/usr/bin/env python3
"""Run the node usb_cam: publish the images of a camera, a video, an image file or a test scene."""
import signal
import sys

if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    from img_recog.nodes.usb_cam.usb_cam_node import main
    sys.exit(main())
