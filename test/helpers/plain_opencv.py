"""Masks by cv2.inRange, as a reference."""
import cv2
import numpy as np


def mask(image, color):
    """Return the mask of a color in a bgr8 image; its range of hues must not wrap around."""
    bounds = color.hue, color.saturation, color.value
    return cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV),
                       *(np.array([low_high[end] for low_high in bounds]) for end in (0, 1)))


# of the article: lowest and highest hue, saturation and value, and linear.x in m/s
ARTICLE = (('blue', (50, 100, 100), (150, 255, 255), 10.0),
           ('red', (150, 100, 150), (180, 255, 255), -10.0))
AREA_LIMIT_PX = 1000


def results(image):
    """Return the area in pixels and the masked image of each color of the article, of bgr8."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    masks = [cv2.inRange(hsv, np.array(low), np.array(high)) for _, low, high, _ in ARTICLE]
    return [(cv2.countNonZero(mask), cv2.bitwise_and(image, image, mask=mask)) for mask in masks]


def areas_px(image):
    """Return the area of each color of the article in a bgr8 image."""
    return [area_px for area_px, _ in results(image)]


def commands(image):
    """Return linear.x of each command of the article for a bgr8 image, in order."""
    return [speed for area_px, (_, _, _, speed) in zip(areas_px(image), ARTICLE)
            if area_px > AREA_LIMIT_PX]
