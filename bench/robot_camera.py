"""The demo with a camera on the robot: real time factor, frames, CPU, and pauses of /clock."""
import os
import sys
from statistics import median
from typing import Callable

from ros_processes import HERE, Master, run_script, wait_for

PACKAGE = os.path.dirname(HERE)
ROUNDS, SECONDS = 3, 10.0
WORLD, VIEW = 'world:=color_posts', '/gazebo/view/image_raw'
# title, camera, and whether somebody looks at the view
CASES = (('camera:=synthetic', 'synthetic', False), ('camera:=robot', 'robot', False),
         ('camera:=robot, with the view', 'robot', True))
PARTS = ('gazebo', 'camera', 'color_extract', 'others')
PAUSES = ('nobody', 'the camera', 'the view too')


def demo(camera: str, is_viewed: bool) -> dict:
    """Return what robot_camera_sample.py measures with a new demo, at 640x480 and 30 Hz."""
    with Master() as master:
        launch = master.start('roslaunch', 'img_recog', 'demo.launch', 'camera:=' + camera, WORLD,
                              'gui:=false', 'image_view:=false')
        wait_for(lambda: '/cmd_vel' in dict(master.server.getPublishedTopics('')), 'the demo')
        if is_viewed:
            master.start(sys.executable, os.path.join(HERE, 'watch_images.py'), VIEW)
            wait_for(lambda: VIEW in dict(master.server.getSystemState()[1]), 'the viewer')
        return run_script('robot_camera_sample.py', SECONDS, master.pid, launch.pid,
                          env=master.env)


def pauses() -> list:
    """Return what stall_sample.py measures with a new simulator."""
    with Master() as master:
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            master.server.setParam('/robot_description', file.read())
        master.server.setParam('/use_sim_time', True)
        master.start(sys.executable, os.path.join(PACKAGE, 'scripts', 'pybullet_sim.py'),
                     '__name:=gazebo', '_' + WORLD, '_camera_frame:=camera_link',
                     '_camera_image_topic:=usb_cam/image_raw',
                     '_camera_info_topic:=usb_cam/camera_info')
        wait_for(lambda: '/clock' in dict(master.server.getPublishedTopics('')), 'the simulator')
        return run_script('stall_sample.py', 3.0, env=master.env)


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * (len(CASES) + 1)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over several rounds, and the longest pauses.

    done: called after each measurement.
    """
    samples: dict = {case: [] for case in CASES}
    stalls = []
    for _ in range(ROUNDS):
        for case in CASES:
            samples[case].append(demo(*case[1:]))
            done()
        stalls.append(pauses())
        done()
    rows = []
    for case, found in samples.items():
        row = {key: median(each[key] for each in found)
               for key in ('real_time_factor', 'lowest_factor', 'period_ms')}
        for key in ('frames', 'lost', 'not_recognized'):
            counts = [each[key] for each in found]
            row[key] = None if None in counts else sum(counts)
        row.update((part, median(each['cpu_share'][part] for each in found)) for part in PARTS)
        row['sum'] = median(sum(each['cpu_share'].values()) for each in found)
        rows.append(dict(row, case=case[0]))
    return {'demo': rows, 'pauses': [
        {'subscribers': name, 'pause_ms': median(each[number]['pause_ms'] for each in stalls),
         'longest_ms': max(each[number]['pause_ms'] for each in stalls),
         'first_ms': median(each[number]['first_ms'] for each in stalls)}
        for number, name in enumerate(PAUSES)]}


def table(results: dict) -> str:
    """Return the results as two tables."""
    lines = ['{:30} {:>9} {:>7} {:>8} {:>6} {:>37} {:>7}'.format(
        'demo in color_posts, 640x480', 'real time', 'frame', 'frames', 'not', 'CPU of a core',
        'sum'), '{:30} {:>9} {:>7} {:>8} {:>6} {:>8} {:>8} {:>10} {:>8}'.format(
            '', 'factor', 'every', 'lost', 'seen', 'gazebo', 'camera', 'extract', 'others')]
    for row in results['demo']:
        counts = ['-' if row[key] is None else row[key] for key in ('lost', 'not_recognized')]
        lines.append('{case:30} {real_time_factor:9.3f} {period_ms:4.0f} ms {:>8} {:>6} '
                     '{gazebo:8.1%} {camera:8.1%} {color_extract:10.1%} {others:8.1%} '
                     '{sum:7.1%}'.format(*counts, **row))
    lines += ['', '{:30} {:>20} {:>10} {:>14}'.format(
        'a new subscriber of', 'longest clock pause', 'worst', 'first message')]
    for row in results['pauses']:
        lines.append('{subscribers:30} {pause_ms:17.0f} ms {longest_ms:7.0f} ms '
                     '{first_ms:11.0f} ms'.format(**row))
    return '\n'.join(lines)
