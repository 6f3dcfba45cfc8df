"""A camera in a world of textured meshes: the time to its first image, and images a second."""
import os
import sys
import tempfile
import time
from statistics import median
from typing import Callable, Dict

import raw_topics
import textured_world
from ros_processes import HERE, Master

PACKAGE = os.path.dirname(HERE)
ROUNDS, SECONDS = 3, 5.0
POLL_PERIOD_S = 0.02
TOPIC = '/usb_cam/image_raw'
STARTS = {'first': 'the first start', 'next': 'the next start'}


def start(world: str, cache: str) -> Dict[str, float]:
    """Return what a new simulator with a camera of 640x480 at 30 Hz does: first_s, images_per_s.

    first_s: from its start to the first image; cache: its folder for caches.
    """
    with Master() as master:
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            master.server.setParam('/robot_description', file.read())
        master.env['XDG_CACHE_HOME'] = cache
        begin_s = time.perf_counter()
        master.start(sys.executable, os.path.join(PACKAGE, 'scripts', 'pybullet_sim.py'),
                     '__name:=gazebo', '_world:=' + world, '_camera_frame:=camera_link',
                     '_camera_image_topic:=usb_cam/image_raw',
                     '_camera_info_topic:=usb_cam/camera_info')
        with raw_topics.connect(TOPIC, master.env['ROS_MASTER_URI'], POLL_PERIOD_S) as sock:
            images = raw_topics.messages(sock)
            next(images)
            first_s, count = time.perf_counter() - begin_s, 0
            while time.perf_counter() < begin_s + first_s + SECONDS:
                next(images)
                count += 1
            return {'first_s': first_s, 'images_per_s': count / SECONDS}


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * len(STARTS)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians of several rounds, each with an empty cache and then with its files.

    done: called after each measurement.
    """
    samples: Dict[str, list] = {name: [] for name in STARTS}
    with tempfile.TemporaryDirectory() as folder:
        world = textured_world.write(folder)
        for number in range(ROUNDS):
            for found in samples.values():
                found.append(start(world, os.path.join(folder, 'cache_{}'.format(number))))
                done()
    return {name: {key: median(sample[key] for sample in found) for key in found[0]}
            for name, found in samples.items()}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:42} {:>12} {:>10}'.format(
        '{} textured meshes, camera 640x480'.format(textured_world.MODELS), 'first image',
        'images/s')]
    lines += ['{:42} {first_s:10.2f} s {images_per_s:10.1f}'.format(words, **results[name])
              for name, words in STARTS.items()]
    return '\n'.join(lines)
