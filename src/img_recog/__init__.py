"""Drive a robot by the colors a camera sees."""
import os

# OpenCV reads these once, when it is loaded. The first is the wall behind max_image_pixels
# (formats/still_images.py), 16384x16384 pixels instead of 2**30. The other silences the lines that
# OpenCV prints about each file and at each retry: the package says the same in a line of its own.
for _name, _value in (('OPENCV_IO_MAX_IMAGE_PIXELS', str(1 << 28)),
                      ('OPENCV_LOG_LEVEL', 'SILENT')):
    os.environ.setdefault(_name, _value)
