"""Frame sources, their pacing, controls and calibration; knows no ROS."""
import os

# OpenCV waits 10 s for a frame of a silent V4L2 device. It looks into the environment once, at the
# latest when it waits for the first time: here it is set before any source can be opened.
os.environ.setdefault('OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT', '2')
