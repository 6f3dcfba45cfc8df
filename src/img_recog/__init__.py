"""Drive a robot by the colors a camera sees."""
import os

# OpenCV reads this once, when it is loaded: the wall behind max_image_pixels (still_images.py),
# 16384x16384 pixels instead of 2**30.
os.environ.setdefault('OPENCV_IO_MAX_IMAGE_PIXELS', str(1 << 28))
