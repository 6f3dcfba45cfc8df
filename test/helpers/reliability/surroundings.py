"""What happens around the nodes: time that jumps, and a full disk."""
import contextlib
import os
import random
import resource
import subprocess
import tempfile
import time
from typing import Dict, List

import genpy
from rosgraph_msgs.msg import Clock

from img_recog_helpers import wire
from img_recog_helpers.reliability import chain, faults
from img_recog_helpers.reliability import demo as demos
from img_recog_helpers.reliability.demo import LIMIT_S, START_LIMIT_S, Demo
from img_recog_helpers.reliability.nodes import Nodes

_DISK_KB = 1024
_MAX_CLOCK_S = 4294967295.0       # of a time in ROS 1
_MAX_TRACEBACKS, _MAX_OUTPUT_LINES = 3, 40      # of all nodes, about the full disk


def clock_jumps(count: int, seed: int, nodes: Nodes, factor: float = 1.0) -> List[float]:
    """Let /clock jump forward, backward and to zero; return the seconds until the chain worked.

    Camera and recognition use the time of /clock, which no simulator publishes here.
    """
    rng = random.Random(seed)
    nodes.set_parameters('/use_sim_time', True)
    film = os.path.join(nodes.folder, 'film.avi')
    chain.write_film(film)
    now_s, times_s = 1000.0, []
    # each new connection gets the time, as nodes may connect at any moment, or again
    clock = wire.RawPublisher(nodes.master_uri, '/clock', Clock, '/clock_source',
                              first=Clock(genpy.Time.from_sec(now_s)))
    scripts = [nodes.start_node('usb_cam_node.py', '_video_device:=' + film),
               nodes.start_node('color_img_recog.py', '_blue_linear_x:={}'.format(chain.SPEED),
                                '_red_linear_x:={}'.format(-chain.SPEED)),
               nodes.start_node('teleop_key.py')]
    check = chain.Chain(nodes.master_uri, chain.RECOGNITION + (chain.TELEOP,))
    try:
        check.wait(START_LIMIT_S * factor)
        for _ in range(count):
            now_s = rng.choice((0.0, 1.0, now_s + 3600.0, now_s - 3600.0, _MAX_CLOCK_S,
                                rng.uniform(0, 1e9)))
            now_s = min(max(now_s, 0.0), _MAX_CLOCK_S)
            for _ in range(rng.randrange(1, 5)):
                clock.publish(Clock(genpy.Time.from_sec(now_s)))
                now_s = min(now_s + 0.01, _MAX_CLOCK_S)
            times_s.append(check.wait(LIMIT_S * factor).recovered_s)
        for each in scripts:
            assert each.is_running() and 'Traceback' not in each.output, each.output[-3000:]
    except chain.ChainError as error:
        raise chain.ChainError('{}; the nodes run: {}\n{}'.format(
            error, [each.is_running() for each in scripts], nodes.output()[-3000:])) from error
    finally:
        for each in scripts:        # their images and their clock are not for what comes next
            each.close()
        clock.close()
        nodes.set_parameters('/use_sim_time', False)
    return times_s


class SmallDisk:
    """A folder for logs whose disk can be filled; use it in a with statement.

    It is a small tmpfs where that is allowed. Elsewhere the limit of the size of files of the
    running nodes has the same effect on what they write.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix='img_recog_disk_')
        self.path = self._folder.name
        self._is_mounted = os.geteuid() == 0 and subprocess.run(
            ['mount', '-t', 'tmpfs', '-o', 'size={}k'.format(_DISK_KB), 'none', self.path],
            stderr=subprocess.DEVNULL, check=False).returncode == 0

    def __enter__(self) -> 'SmallDisk':
        return self

    def __exit__(self, *_) -> None:
        if self._is_mounted:
            subprocess.run(['umount', '-l', self.path], check=True)
        self._folder.cleanup()

    def fill(self, demo: Demo) -> None:
        """Leave no room; without a disk of its own, only for the nodes of this package."""
        if self._is_mounted:
            with open(os.path.join(self.path, 'filler'), 'wb', buffering=0) as file, \
                    contextlib.suppress(OSError):
                while True:
                    file.write(bytes(1024))
        for node in () if self._is_mounted else faults.OURS:
            resource.prlimit(demo.pid(node), resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))


def endure_full_disk(demo: Demo, disk: SmallDisk, duration_s: float, factor: float = 1.0
                     ) -> Dict[str, float]:
    """Fill the disk of a running demo; return how the chain works and what is printed."""
    before = len(demo.launch.output)
    disk.fill(demo)
    end, times_s = time.monotonic() + duration_s, []
    while time.monotonic() < end or not times_s:
        times_s.append(demo.chain.wait(LIMIT_S * factor).complete_s)
    output = demo.launch.output[before:]
    lines = [line for line in output.splitlines() if 'the robot' not in line
             and 'blue=' not in line]
    tracebacks = output.count('Traceback')
    assert tracebacks <= _MAX_TRACEBACKS and len(lines) <= _MAX_OUTPUT_LINES, \
        '{} tracebacks\n{}'.format(tracebacks, '\n'.join(lines)[-3000:])
    return {'max_s': max(times_s), 'tracebacks': tracebacks, 'lines': len(lines)}


def full_disk(duration_s: float, factor: float = 1.0) -> Dict[str, float]:
    """Run a demo, fill its disk; return how the chain works and what is printed."""
    with SmallDisk() as disk, demos.running(factor, ROS_LOG_DIR=disk.path) as demo:
        return endure_full_disk(demo, disk, duration_s, factor)
