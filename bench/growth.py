"""CPU time of a frame by parts, from small images to 4K."""
import json
import os
import tempfile
from statistics import median
from typing import Callable, Dict, List

import camera
import drawing
import numpy as np
import recognition

SIZES = ((320, 240), (640, 480), (1280, 720), (1920, 1080), (3840, 2160))
KIND, TURNS = 'film', 3
DRAWING_TURNS = 3
# of a frame of color_extract: those of profiled_node.py, and what is between them
PARTS = ('receive', 'message', 'convert', 'masks', 'log', 'commands', 'images', 'send')
REST, SUM, WAKE_UP = 'the rest', 'sum', 'wake-up'
WORDS = {
    'receive': 'copy the image from the socket', 'message': 'read its header',
    'convert': 'OpenCV: to HSV, and to BGR', 'masks': 'masks and areas without that',
    'log': 'the line in the log file and on /rosout', 'commands': 'make and send commands',
    'images': 'draw two masked images', 'send': 'copy them to the sockets',
    REST: 'Python, rospy and the kernel between them', SUM: 'CPU of the node',
    WAKE_UP: 'wall time until it is received'}


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return 3 * len(SIZES)


def frame(width: int, height: int) -> Dict[str, float]:
    """Return the CPU time of the parts of a frame of color_extract, ms, in order; see WORDS."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'profile')

        node = recognition.script('bench', 'profiled_node.py', arguments=(path,))
        turns = recognition.samples({'node': node}, KIND, (width, height), True, TURNS,
                                    rates=False)['node']
        with open(path) as file:
            records = [json.loads(line) for line in file]
    sent_s = np.concatenate([turn['sent_s'] for turn in turns])
    # the last ones; before them, frames without a pause are sent
    before, *measured = records[-len(sent_s) - 1:]

    def part_ms(name: str) -> float:
        return 1e3 * (measured[-1].get(name, 0.0) - before.get(name, 0.0)) / len(measured)
    parts = {part: part_ms(part) for part in PARTS}
    total = part_ms('process')
    waits = np.array([record['complete'] for record in measured]) - sent_s
    return {**parts, REST: total - sum(parts.values()), SUM: total,
            WAKE_UP: 1e3 * float(np.median(waits))}


def camera_ms(folder: str, write: Callable[..., str], size: tuple) -> float:
    """Return the CPU time of a frame of the camera node."""
    return camera.sample(*camera.OURS, '_video_device:=' + write(folder, *size),
                         '_framerate:={}'.format(camera.RATE_HZ))['cpu_ms_a_frame']


def drawing_ms(size: tuple) -> float:
    """Return the CPU time of an image of the robot's camera."""
    sampler = drawing.Sampler('img_recog', 'robot', *size)
    try:
        return median(sampler.sample()['cpu_ms'] for _ in range(DRAWING_TURNS))
    finally:
        sampler.close()


def measure(done: Callable[[], None]) -> dict:
    """Return the CPU times of a frame of each size, ms.

    done: called after each measurement.
    """
    rows: List[dict] = []
    for size in SIZES:
        parts = frame(*size)
        done()
        with tempfile.TemporaryDirectory() as folder:
            film, still = (camera_ms(folder, write, size)
                           for write in (camera.video, camera.still))
        done()
        rows.append({'size': '{}x{}'.format(*size), 'color_extract': parts,
                     'camera, film': film, 'camera, still': still,
                     "drawing for the robot's camera": drawing_ms(size)})
        done()
    return {'rows': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    rows = results['rows']

    def line(title: str, values) -> str:
        return '{:<67}'.format(title) + ''.join('{:>11}'.format(value) for value in values)
    lines = [line('CPU time of a frame, ms', (row['size'] for row in rows))]
    lines += [line('color_extract, {}: {}'.format(part, WORDS[part]), (
        '{:.3f}'.format(row['color_extract'][part]) for row in rows)) for part in WORDS]
    lines += [line(title, ('{:.2f}'.format(row[title]) for row in rows))
              for title in rows[0] if title not in ('size', 'color_extract')]
    return '\n'.join(lines)
