"""Runs all checks of the node usb_cam on the virtual camera of the driver vivid; see run.

Prints one line for each check and a summary; the exit code is 0 when all have passed.
"""
import os
import pathlib
import sys
import tempfile

import cv2
import rospy
from sensor_msgs.msg import Image

from camera_node import PROGRAM, Diagnostics, Topic
from check_capture import check_losses, check_missing, check_rounds
from check_controls import check_controls, parameters
from check_formats import check_formats
from check_images import check_compressed, check_rate
from img_recog_testing.processes import Ros
from report import Report
from vivid import AUTO_GAIN, DRIVER, Vivid


def run(report, ros, folder):
    """Run the checks of separate nodes, then those of one node that opens a symlink."""
    ros.start_master()
    os.environ.update(ros.env)
    rospy.init_node('v4l2_checks', disable_signals=True)
    vivid = Vivid()
    print('kernel {}, {}, OpenCV {}'.format(os.uname().release, vivid.path, cv2.__version__),
          flush=True)
    check_formats(report, ros, vivid)
    check_missing(report, ros, vivid)

    link = folder / 'a camera by id'
    link.symlink_to(vivid.path)
    vivid.set(AUTO_GAIN, 0)         # with automatic gain the driver changes gain
    rospy.set_param('/usb_cam', {
        'video_device': str(link), 'pixel_format': 'yuyv', 'image_width': 320,
        'image_height': 180, 'framerate': 20, **parameters()})
    node = ros.start(PROGRAM, '__name:=usb_cam')
    images, diagnostics = Topic('/usb_cam/image_raw', Image), Diagnostics()
    with report.check('images by a symlink', node):
        images.wait_more(2)
    check_controls(report, vivid, node)
    check_rate(report, vivid, node, images)
    check_compressed(report, node, images)
    check_rounds(report, vivid, node, images)
    check_losses(report, vivid, node, images, diagnostics)


def main():
    """Run the checks; return the exit code."""
    if not os.path.isdir(DRIVER):
        sys.exit('the driver vivid is not loaded; use the script run in this folder')
    report = Report()
    with tempfile.TemporaryDirectory() as name, Ros(name) as ros:
        try:
            with report.check('all checks were run'):
                run(report, ros, pathlib.Path(name))
        finally:
            rospy.signal_shutdown('done')
    print(report.summary(), flush=True)
    return 1 if report.failed else 0


if __name__ == '__main__':
    sys.exit(main())
