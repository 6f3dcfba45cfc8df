"""CPU time, rate and jitter of the camera node and of the distribution's C++ image_publisher.

The jitter of a process that only sends a prepared image is the floor for both.
"""
import os
import sys
import tempfile
from statistics import median
from typing import Callable

import cv2
import pictures
from ros_processes import Master, installed, run_script, wait_for

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
THEIRS = ('rosrun', 'image_publisher', 'image_publisher')
BARE = (sys.executable, os.path.join(PACKAGE, 'bench', 'bare_camera.py'))
OURS = (sys.executable, os.path.join(PACKAGE, 'scripts', 'usb_cam_node.py'))
ROUNDS, SECONDS = 3, 8.0
SIZES = ((640, 480), (1920, 1080))
RATE_HZ, FRAMES = 30, 150
UNBOUNDED_HZ = 1000                 # more than any node reaches


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
    """Return what image_sample.py measures while a node publishes images."""
    with Master() as master:
        process = master.start(*command)

        def topic():
            return next((name for name, kind in master.server.getPublishedTopics('')
                         if kind == 'sensor_msgs/Image'), None)
        name = wait_for(topic, 'images of ' + command[0])
        return run_script('image_sample.py', name, SECONDS, process.pid, env=master.env)


def cases() -> list:
    """Return the cases: title, function that writes the file, size and rate."""
    return [('{} {}x{}, {}'.format(name, width, height, words), write, (width, height), rate_hz)
            for width, height in SIZES
            for name, write, words, rate_hz in (
                ('film', video, '30 Hz', RATE_HZ), ('still', still, '30 Hz', RATE_HZ),
                ('still', still, 'highest rate', UNBOUNDED_HZ))]


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return 3 * ROUNDS * len(cases()) if installed('image_publisher') else 0


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over several rounds. Each round measures all three.

    done: called after each measurement.
    """
    rows, samples = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(ROUNDS if installed('image_publisher') else 0):
            for name, write, size, rate_hz in cases():
                path = write(folder, *size)
                found = []
                for command in ((*OURS, '_video_device:=' + path,
                                 '_framerate:={}'.format(rate_hz)),
                                (*THEIRS, path, '_publish_rate:={}'.format(rate_hz)),
                                (*BARE, *map(str, size), str(rate_hz))):
                    found.append(sample(*command))
                    done()
                samples.setdefault(name, []).append(found)
    for name, rounds in samples.items():
        row = {'case': name}
        for prefix, values in zip(('', 'their_', 'bare_'), zip(*rounds)):
            for key in ('rate_hz', 'cpu_ms_a_frame', 'jitter_ms', 'arrival_jitter_ms'):
                row[prefix + key] = median(each[key] for each in values)
        row['cpu_ratio'] = median(ours['cpu_ms_a_frame'] / theirs['cpu_ms_a_frame']
                                  for ours, theirs, _ in rounds)
        rows.append(row)
    return {'rows': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    if not results['rows']:
        return 'camera: not measured, because image_publisher is not installed'
    lines = ['{:30} {:>16} {:>22} {:>7} {:>27} {:>27}'.format(*titles) for titles in (
        ('camera, image_publisher;', 'rate, Hz', 'CPU a frame, ms', 'ratio',
         '99 % jitter, ms: first byte', 'and of the last byte'),
        ('jitter: of a bare sender too', '', '', '', '', ''))]
    for row in results['rows']:
        lines.append('{case:30} {rate_hz:7.1f} {their_rate_hz:8.1f} {cpu_ms_a_frame:13.2f} '
                     '{their_cpu_ms_a_frame:8.2f} {cpu_ratio:7.2f} {jitter_ms:11.2f} '
                     '{their_jitter_ms:7.2f} {bare_jitter_ms:7.2f} {arrival_jitter_ms:13.2f} '
                     '{their_arrival_jitter_ms:6.2f} {bare_arrival_jitter_ms:6.2f}'.format(**row))
    return '\n'.join(lines)
