"""What the videos and images of the tests show."""
import cv2
import numpy as np

VIDEO_RATE_HZ = 12.5


def smooth_image(number, width=96, height=64):
    """Draw a bgr8 gradient, different for each number, that codecs keep well."""
    ramp = np.linspace(0, 150, width) + 15 * number
    image = np.empty((height, width, 3), np.uint8)
    image[..., 0], image[..., 1], image[..., 2] = 40, 90, ramp
    return image


def opencv_frames(path):
    """Return all frames of a video as OpenCV's VideoCapture reads them, in rgb8."""
    capture, frames = cv2.VideoCapture(path, cv2.CAP_FFMPEG), []
    good, image = capture.read()
    while good:
        frames.append(image[..., ::-1].copy())
        good, image = capture.read()
    capture.release()
    return frames
