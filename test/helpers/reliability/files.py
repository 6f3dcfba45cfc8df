"""Hostile files to what reads them: images, videos, calibrations, robots, worlds and bags."""
import contextlib
import math
import os
import random
import re
import signal
import tempfile
import time
from typing import Callable, Dict, Iterator, List, Tuple

import cv2
import genpy
import numpy as np
import psutil
import rosbag

from img_recog.camera import calibration
from img_recog.camera.selection import open_file
from img_recog.camera.source import FrameSkipped, SourceEnded
from img_recog.checks import robot_check, world_check
from img_recog.errors import UserError
from img_recog.formats import still_images, world_file
from img_recog.loading import resources
from img_recog.recordings.bags import BagFrames
from img_recog_helpers import bombs
from img_recog_helpers.parsed import lumped
from img_recog_helpers.reliability import chain, hostile
from img_recog_helpers.simulator_tools import burger

_MAX_S, _MAX_GROWTH_MB = 30.0, 100.0
_MAX_PIXELS = 1 << 22
_NUMBER = re.compile(rb'-?\d+(\.\d+)?')
_NUMBERS = (b'nan', b'inf', b'-1', b'0', b'1e308', b'1e-320', b'99999999999999999999', b'', b'x',
            b'0x10', b'1 2', b'true', b'[]', b'.inf')
_CALIBRATION = b"""image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.001, 0.002, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}
"""
_WORLD = b"""<sdf version="1.6"><world name="w"><gravity>0 0 -9.8</gravity>
<light name="sun" type="directional"><cast_shadows>1</cast_shadows></light>
<model name="box"><pose>1 2 0.5 0 0 0.3</pose><static>0</static><link name="link">
<inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
<visual name="v"><geometry><cylinder><radius>0.5</radius><length>1</length></cylinder></geometry>
<material><ambient>1 0 0 1</ambient></material></visual></link></model></world></sdf>
"""


def _text(data: bytes, rng: random.Random) -> bytes:
    """Damage a text: its bytes, its numbers or its lines."""
    kind = rng.randrange(4)
    if kind == 0:
        return hostile.damaged(data, rng)
    if kind == 1:
        share = rng.choice((0.02, 0.1, 1.0))
        return _NUMBER.sub(lambda found: rng.choice(_NUMBERS) if rng.random() < share
                           else found.group(), data)
    words = re.split(rb'(?<=[>\n])', data)
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(words))
        words[place:place + rng.randrange(3)] = [] if kind == 2 else [
            rng.choice(words)] * rng.choice((1, 2, 1000))
    return b''.join(words)


def _bytes(data: bytes, rng: random.Random) -> bytes:
    """Damage bytes: some of them, or the end is missing."""
    if rng.random() < 0.2:
        return data[:rng.randrange(len(data))]
    for _ in range(rng.choice((1, 1, 10))):
        data = hostile.damaged(data, rng)
    return data


def _images() -> List[bytes]:
    ramp = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
    return [cv2.imencode(ending, ramp)[1].tobytes() for ending in (
        '.jpg', '.png', '.bmp', '.tiff', '.webp', '.ppm')] + [
            bombs.png(), bombs.lying_png(), bombs.jpeg(), *bombs.headers().values()]


def _videos(folder: str) -> List[bytes]:
    found = []
    for code, ending in (('MJPG', 'avi'), ('mp4v', 'mp4'), ('MJPG', 'mkv'), ('VP80', 'webm')):
        path = os.path.join(folder, 'video.' + ending)
        video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*code), 30, (64, 48))
        for number in range(20):
            video.write(np.full((48, 64, 3), number * 10, np.uint8))
        video.release()
        found.append(_content(path))
    return found


def _bags(folder: str) -> List[bytes]:
    found = []
    for compression in ('none', 'bz2', 'lz4'):
        path = os.path.join(folder, 'made.bag')
        with rosbag.Bag(path, 'w', compression=compression) as bag:
            for number, color in enumerate(('blue', 'red', 'nothing')):
                bag.write('/usb_cam/image_raw', chain.message(color), genpy.Time(1 + number))
        found.append(_content(path))
    return found


def _content(path: str) -> bytes:
    with open(path, 'rb') as file:
        return file.read()


def _play(path: str) -> None:
    source = open_file(path, 30.0, False, max_pixels=_MAX_PIXELS)
    try:
        for _ in range(100):
            with contextlib.suppress(FrameSkipped):
                source.read()
    except SourceEnded:
        pass
    finally:
        source.close()


def _replay(path: str) -> None:
    frames = BagFrames(path, max_pixels=_MAX_PIXELS)
    with frames.bag:
        frames.camera_infos()
        for _ in frames:
            pass


def _read_robot(path: str) -> None:
    with open(path, errors='replace') as file:
        lumped(file.read())


def _read_world(path: str) -> None:
    world_file.read(path, resources.worlds(), resources.find, True)


class _Kind:
    """A kind of files: what is damaged, how, and what reads it.

    share: of all files; max_growth_mb: of memory.
    """

    max_growth_mb = _MAX_GROWTH_MB

    def __init__(self, ending: str, share: float, sources: List[bytes], damage: Callable,
                 *readers: Callable[[str], object]):
        self.ending, self.share, self.sources = ending, share, sources
        self.damage, self.readers = damage, readers


class _Simulated(_Kind):
    """A kind of files that PyBullet loads: about 36 MB, until the end of the program.

    A program loads one world; here many are loaded in one process.
    """

    max_growth_mb = math.inf


def _kinds(folder: str) -> Dict[str, _Kind]:
    urdf = burger().encode()
    return {
        'images': _Kind('png', 0.2, _images(), _bytes, _play, still_images.count,
                        lambda path: still_images.read(path, _MAX_PIXELS)),
        'videos': _Kind('avi', 0.2, _videos(folder), _bytes, _play),
        'calibrations': _Kind('yaml', 0.2, [_CALIBRATION], _text, calibration.load),
        'robots': _Kind('urdf', 0.1, [urdf], _text, _read_robot),
        'worlds': _Kind('world', 0.1, [_WORLD], _text, _read_world),
        'bags': _Kind('bag', 0.1, _bags(folder), _bytes, _replay),
        'simulated robots': _Simulated('urdf', 0.05, [urdf], _text, robot_check.check),
        'simulated worlds': _Simulated('world', 0.05, [_WORLD], _text, world_check.check)}


@contextlib.contextmanager
def _limited(path: str) -> Iterator[None]:
    """End this process if reading a file hangs; the file stays."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(int(_MAX_S * 4))
    yield
    signal.alarm(0)


def run(count: int, seed: int) -> List[Tuple[int, str, str]]:
    """Read `count` files; return the number of each kind, its name, and how reading went.

    A file that fails stays: in the folder of temporary files. Raises AssertionError, or ends this
    process.
    """
    rng, rows = random.Random(seed), []
    with tempfile.TemporaryDirectory() as folder, hostile.quiet_libraries():
        for name, kind in _kinds(folder).items():
            number = max(1, round(count * kind.share))
            rows.append((number, name, _read_all(number, kind, rng)))
    return rows


def _read_all(count: int, kind: _Kind, rng: random.Random) -> str:
    refused, longest_s, before_mb = 0, 0.0, 0.0
    path = os.path.join(tempfile.gettempdir(), 'img_recog_hostile_{}.{}'.format(
        os.getpid(), kind.ending))
    for number in range(count):
        with open(path, 'wb') as file:
            file.write(kind.damage(rng.choice(kind.sources), rng))
        for reader in kind.readers:
            begin_s = time.process_time()
            try:
                with _limited(path):
                    reader(path)
            except (UserError, still_images.ImageTooLarge):
                refused += 1
            except Exception as error:
                raise AssertionError('{}: {!r}'.format(path, error)) from error
            longest_s = max(longest_s, time.process_time() - begin_s)
            assert longest_s < _MAX_S, '{}: {:.1f} s'.format(path, longest_s)
        if number == count // 2:        # libraries are loaded by the first ones
            before_mb = _rss_mb()
    growth_mb = _rss_mb() - before_mb
    assert growth_mb < kind.max_growth_mb, '{}: {:+.0f} MB'.format(kind.ending, growth_mb)
    os.remove(path)
    return '{} refused, longest {:.2f} s, memory {:+.0f} MB'.format(refused, longest_s, growth_mb)


def _rss_mb() -> float:
    return psutil.Process().memory_info().rss / 1e6
