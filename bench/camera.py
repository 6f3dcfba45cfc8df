"""CPU time, rate and jitter of the camera node and of the distribution's C++ image_publisher."""
import os
import sys
import tempfile
import time
from functools import partial
from typing import Callable, List, Tuple

import cv2
import numpy as np
import pictures
import raw_topics
from pairs import Benchmark, Column, Samples
from ros_processes import PACKAGE, Master, cpu_s, installed, wait_for

THEIRS = ('rosrun', 'image_publisher', 'image_publisher')
OURS = (sys.executable, os.path.join(PACKAGE, 'scripts', 'usb_cam_node.py'))
SKIPPED, SECONDS = 30, 8.0      # images at the start
SIZES = ((640, 480), (1920, 1080))
RATE_HZ, FRAMES = 30, 150


def video(folder: str, width: int, height: int) -> str:
    """Write a film and return its path."""
    path = os.path.join(folder, 'video_{}.avi'.format(width))
    writer = cv2.VideoWriter(path, cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*'MJPG'), RATE_HZ,
                             (width, height))
    frames = [cv2.cvtColor(frame, cv2.COLOR_RGB2BGR) for frame in pictures.film(width, height)]
    for number in range(FRAMES):
        writer.write(frames[number % len(frames)])
    writer.release()
    return path


def still(folder: str, width: int, height: int) -> str:
    """Write a frame of the film and return its path."""
    path = os.path.join(folder, 'still_{}.png'.format(width))
    cv2.imwrite(path, cv2.cvtColor(pictures.film(width, height)[0], cv2.COLOR_RGB2BGR))
    return path


def sample(*command: str) -> dict:
    """Return rate, CPU time and jitter of a node that publishes images, read like by a viewer."""
    arrivals: List[float] = []      # of the last byte of each image
    with Master() as master:
        pid = master.start(*command).pid
        topic = wait_for(lambda: next((
            name for name, kind in master.server.getPublishedTopics('')
            if kind == 'sensor_msgs/Image'), None), 'images of ' + command[0])
        with raw_topics.connect(topic, master.env['ROS_MASTER_URI']) as sock:
            messages = raw_topics.messages(sock)
            for _ in range(SKIPPED):
                next(messages)
            before, end = cpu_s(pid), time.perf_counter() + SECONDS
            while not arrivals or arrivals[-1] < end:
                next(messages)
                arrivals.append(time.perf_counter())
            processor = cpu_s(pid) - before
    return {'rate_hz': (len(arrivals) - 1) / (arrivals[-1] - arrivals[0]),
            'cpu_ms_a_frame': 1e3 * processor / len(arrivals),
            'jitter_ms': _jitter_ms(arrivals)}


def _jitter_ms(times: List[float]) -> float:
    """Return by how much 99 % of the periods differ at most from the median."""
    periods = np.diff(times)
    return float(1e3 * np.percentile(np.abs(periods - np.median(periods)), 99))


def _case(write: Callable[[str, int, int], str], size: Tuple[int, int]) -> Samples:
    with tempfile.TemporaryDirectory() as folder:
        path = write(folder, *size)
        return {name: [sample(*command)] for name, command in (
            ('img_recog', (*OURS, '_video_device:=' + path, '_framerate:={}'.format(RATE_HZ))),
            *[('image_publisher', (*THEIRS, path, '_publish_rate:={}'.format(RATE_HZ)))]
            * installed('image_publisher'))}


def benchmark() -> Benchmark:
    """Return what a frame costs, and how evenly they come."""
    return Benchmark('camera, 30 Hz', {
        '{} {}x{}'.format(name, *size): partial(_case, write, size)
        for size in SIZES for name, write in (('film', video), ('still', still))}, (
            Column('rate, Hz', 'rate_hz', '{:.1f}'),
            Column('CPU a frame, ms', 'cpu_ms_a_frame', has_ratio=True),
            Column('99 % jitter of the last byte, ms', 'jitter_ms')))
