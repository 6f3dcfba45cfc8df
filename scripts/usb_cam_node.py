#!/usr/bin/env python3
"""Run the node usb_cam: publish the images of a camera, a video, an image file or a test scene."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.nodes.usb_cam.usb_cam_node')
