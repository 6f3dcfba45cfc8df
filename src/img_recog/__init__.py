"""Drive a robot by the colors a camera sees."""
import os

# OpenCV reads the first two once, when it is loaded, the last one when it opens its first video.
# The first is the wall behind max_image_pixels (still_images.py), 16384x16384 pixels instead of
# 2**30. The others silence the lines that OpenCV and its FFmpeg print about each file and at each
# retry: the package says the same in one line of its own. -8 is AV_LOG_QUIET.
for _name, _value in (('OPENCV_IO_MAX_IMAGE_PIXELS', str(1 << 28)),
                      ('OPENCV_LOG_LEVEL', 'SILENT'), ('OPENCV_FFMPEG_LOGLEVEL', '-8')):
    os.environ.setdefault(_name, _value)
