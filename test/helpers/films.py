"""Pictures of films, and what they show."""
import cv2
import numpy as np

BLUE = (215, 70, 25)
SQUARE = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
ROBOT, PATH = (74, 163, 22), (235, 99, 37)


def card(color=BLUE):
    image = np.full((120, 160, 3), 190, np.uint8)
    image[30:90, 40:120] = color
    return image


def draw(film, time_s=1.0, pose=(2.0, 2.0, 0.0), masked=None, areas_px=(4800, 0)):
    """Return the next picture of a FilmPicture."""
    image = card()
    masked = masked or [np.where((image == BLUE).all(axis=2, keepdims=True), image, 0),
                        np.zeros_like(image)]
    film.pose, film.asked, film.driven = pose, 0.2, 0.1
    return film.draw(time_s, image, masked, areas_px)


def center_of(picture, color, tolerance=3):
    """Return the middle (x, y) of the pixels of a color; None if there are none."""
    rows, columns = np.nonzero((abs(picture.astype(int) - color) <= tolerance).all(axis=2))
    return (columns.mean(), rows.mean()) if len(rows) else None


def frames_of(path):
    video = cv2.VideoCapture(str(path))
    frames = []
    while True:
        there, frame = video.read()
        if not there:
            return frames, video.get(cv2.CAP_PROP_FPS)
        frames.append(frame)
