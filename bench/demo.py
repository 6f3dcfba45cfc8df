"""What the whole demo costs with a camera on the robot, in real time."""
import time
from typing import Dict

from pairs import Benchmark, Column, each
from ros_processes import Master, cpu_s, descendants, wait_for

SECONDS, VIEW = 10.0, '/gazebo/view/image_raw'
# words in the command line of a process, and what it is counted as
KINDS = (('respawn.py', 'others'), ('pybullet_sim.py', 'gazebo'), ('multiprocessing', 'camera'),
         ('usb_cam_node.py', 'camera'), ('color_img_recog.py', 'color_extract'))


def kind_of(pid: int) -> str:
    """Return what a process is counted as."""
    with open('/proc/{}/cmdline'.format(pid)) as file:
        command = file.read()
    return next((kind for word, kind in KINDS if word in command), 'others')


def cpu_of_all(*pids: int) -> Dict[str, float]:
    """Return the CPU time so far of all descendants of processes, in s, by kind."""
    sums = {kind: 0.0 for _, kind in KINDS}
    for pid in descendants(*pids):
        try:
            sums[kind_of(pid)] += cpu_s(pid)
        except OSError:         # it has ended meanwhile
            continue
    return sums


def demo(camera: str, is_viewed: bool = False) -> Dict[str, float]:
    """Return the shares of a core of a new demo, at 640x480 and 30 Hz."""
    with Master() as master:
        launch = master.start('roslaunch', 'img_recog', 'demo.launch', 'camera:=' + camera,
                              'world:=color_posts', 'gui:=false', 'image_view:=false')
        wait_for(lambda: '/cmd_vel' in dict(master.server.getPublishedTopics('')), 'the demo')
        if is_viewed:
            master.watch(VIEW)
        time.sleep(SECONDS / 2)         # what it does once
        before, begin_s = cpu_of_all(master.pid, launch.pid), time.perf_counter()
        time.sleep(SECONDS)
        after, wall_s = cpu_of_all(master.pid, launch.pid), time.perf_counter() - begin_s
    shares = {kind: (after[kind] - before[kind]) / wall_s for kind in after}
    return {**shares, 'sum': sum(shares.values())}


def benchmark() -> Benchmark:
    """Return what the demo takes of a core."""
    return Benchmark('demo in color_posts, 640x480: CPU of a core', {'': each(**{
        'camera:=synthetic': lambda: demo('synthetic'),
        'camera:=robot': lambda: demo('robot'),
        'camera:=robot, with the view': lambda: demo('robot', True)})}, [
            Column(name, name, '{:.1%}')
            for name in ('gazebo', 'camera', 'color_extract', 'others', 'sum')])
