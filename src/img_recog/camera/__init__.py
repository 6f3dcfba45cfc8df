"""Frame sources, their pacing, controls and calibration; independent of ROS."""
import os

# OpenCV waits 10 s for a frame of a silent V4L2 device. It reads this variable once, at the latest
# in its first wait, so it is set before any source can be opened.
os.environ.setdefault('OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT', '2')
