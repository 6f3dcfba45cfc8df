"""The virtual camera of the kernel driver vivid, controlled directly and not through the node.

Names, numbers and defaults are those of drivers/media/test-drivers/vivid.
"""
import contextlib
import fcntl
import glob
import os
import pathlib
import struct

import cv2

from img_recog_testing.waiting import wait_for

DRIVER = '/sys/bus/platform/drivers/vivid/'

# linux/v4l2-controls.h, and vivid-ctrls.c for the last one
BRIGHTNESS, CONTRAST, SATURATION, HUE = 0x00980900, 0x00980901, 0x00980902, 0x00980903
AUTO_GAIN, GAIN, PERCENTAGE_DROPPED = 0x00980912, 0x00980913, 0x00f0f040
# linux/videodev2.h
_VIDIOC_S_PARM, _VIDIOC_G_CTRL, _VIDIOC_S_CTRL = 0xc0cc5616, 0xc008561b, 0xc008561c
_VIDEO_CAPTURE, _TIME_PER_FRAME = 1, 0x1000


class Vivid:
    """The device; `path` is its device file."""

    def __init__(self):
        self.path = wait_for(self._find, 'a device of vivid')

    @staticmethod
    def _find():
        found = glob.glob('/sys/bus/platform/devices/vivid.0/video4linux/video*')
        paths = ['/dev/' + os.path.basename(path) for path in sorted(found)]
        return paths[0] if paths and os.path.exists(paths[0]) else None

    def _ioctl(self, request, argument):
        descriptor = os.open(self.path, os.O_RDWR | os.O_NONBLOCK)
        try:
            return fcntl.ioctl(descriptor, request, argument)
        finally:
            os.close(descriptor)

    def get(self, control_id):
        """Return the value of a control."""
        answer = self._ioctl(_VIDIOC_G_CTRL, struct.pack('=Ii', control_id, 0))
        return struct.unpack('=Ii', answer)[1]

    def set(self, control_id, value):
        """Set a control."""
        self._ioctl(_VIDIOC_S_CTRL, struct.pack('=Ii', control_id, value))

    def set_rate(self, hertz):
        """Change the frame rate, even while another program reads frames."""
        self._ioctl(_VIDIOC_S_PARM, struct.pack(
            '=7I', _VIDEO_CAPTURE, _TIME_PER_FRAME, 0, 1, hertz, 0, 0).ljust(204, b'\0'))

    def unplug(self):
        """Remove the device, as if it was unplugged."""
        pathlib.Path(DRIVER, 'unbind').write_text('vivid.0')

    def plug(self):
        """Add the device again; it must get the same device file."""
        pathlib.Path(DRIVER, 'bind').write_text('vivid.0')
        path = wait_for(self._find, 'the device after it was bound again')
        assert path == self.path, '{} came back as {}'.format(self.path, path)

    def streams(self):
        """Return whether this process can read a frame."""
        capture = cv2.VideoCapture(self.path, cv2.CAP_V4L2)
        try:
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*'YUYV'))
            return capture.isOpened() and capture.read()[0]
        finally:
            capture.release()

    def held_by(self, process):
        """Return how many open descriptors of the device a process has."""
        return sum(link == self.path for link in descriptors(process))


def descriptors(process):
    """Return the targets of the open descriptors of a process."""
    links, folder = [], '/proc/{}/fd'.format(process.pid)
    for name in os.listdir(folder):
        with contextlib.suppress(FileNotFoundError):        # closed in the meantime
            links.append(os.readlink(os.path.join(folder, name)))
    return links
