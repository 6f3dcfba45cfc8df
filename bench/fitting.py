"""CPU time of a frame of a film in the first pass of fit_colors.py, beside OpenCV's histogram."""
import os
import tempfile
import time
from statistics import median
from typing import Callable, Dict

import av
import cv2
import numpy as np
import pictures

from img_recog.recognition.areas import ColorExtractor, to_hsv
from img_recog.recognition.fitting.histograms import NOT, Counter, Label
from img_recog.recognition.fitting.limits import BLOB_SIZES, blobs
from img_recog.recognition.settings import with_colors
from img_recog.recordings import parts
from img_recog.recordings.frames import Part

SIZES = ((640, 480), (1920, 1080))
FRAMES, RUNS = 100, 3
_LABEL = Label(NOT, '')
_NOTHING = np.zeros((1, 1), bool)
_SHAPE, _RANGES = [180, 256, 256], [0, 180, 0, 256, 0, 256]


def _decode(path: str) -> None:
    for _ in parts.read(path, Part(0, FRAMES)).read():
        pass


def _count(path: str) -> None:
    counter = Counter()
    for frame in parts.read(path, Part(0, FRAMES)).read():
        counter.add_frame([(_LABEL, to_hsv(frame.image, frame.encoding))])
    counter.result()


def _measure(path: str) -> None:
    extractor = ColorExtractor(with_colors()())
    for frame in parts.read(path, Part(0, FRAMES)).read():
        extractor.measure(frame.image, frame.encoding)
        for number in range(2):
            blobs(extractor.mask(number), BLOB_SIZES, _NOTHING, _NOTHING)


def _plain(path: str) -> None:
    """Do what a few lines of OpenCV do: its own decoder, and a histogram that accumulates."""
    capture, counts = cv2.VideoCapture(path), np.zeros(_SHAPE, np.float32)
    good, bgr = capture.read()
    while good:
        cv2.calcHist([cv2.cvtColor(bgr, cv2.COLOR_BGR2HSV)], [0, 1, 2], None, _SHAPE, _RANGES,
                     counts, True)
        good, bgr = capture.read()


WAYS: Dict[str, Callable[[str], None]] = {
    'decode': _decode, 'decode and histogram': _count, 'decode and areas': _measure,
    'plain cv2.calcHist loop': _plain}


def _write_film(path: str, width: int, height: int) -> None:
    images = pictures.film(width, height)
    with av.open(path, 'w') as container:
        stream = container.add_stream('h264', 30)
        stream.width, stream.height, stream.pix_fmt = width, height, 'yuv420p'
        for number in range(FRAMES):
            frame = av.VideoFrame.from_ndarray(images[number % len(images)], 'rgb24')
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return len(SIZES) * RUNS


def measure(done: Callable[[], None]) -> dict:
    """Return the median CPU time of a frame, ms; done: called after each measurement."""
    cv2.setNumThreads(1)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for width, height in SIZES:
            path = os.path.join(folder, '{}.mp4'.format(width))
            _write_film(path, width, height)
            times_ms = {way: [] for way in WAYS}
            for _ in range(RUNS):
                for way, run in WAYS.items():
                    begin_s = time.process_time()
                    run(path)
                    times_ms[way].append(1000 * (time.process_time() - begin_s) / FRAMES)
                done()
            rows += [{'size': '{}x{}'.format(width, height), 'way': way, 'cpu_ms': median(each)}
                     for way, each in times_ms.items()]
    return {'rows': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    return '\n'.join(['fit_colors.py, of a film of {} frames {:>30}'.format(FRAMES, 'CPU a frame'),
                      *('{:<10} {:<40} {:>8.2f} ms'.format(row['size'], row['way'], row['cpu_ms'])
                        for row in results['rows'])])
