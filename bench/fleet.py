"""What several robots in one simulator cost, and how many of them run in real time."""
from functools import partial
from typing import NamedTuple

from pairs import Benchmark, Column, Samples
from ros_processes import Master, run_script, wait_for

NUMBERS, SECONDS = (1, 2, 4, 8, 16), 5.0
TOPICS = ('imu', 'joint_states', 'odom', 'scan')
CAMERA = {'camera_frame': 'camera_link', 'camera_image_topic': 'usb_cam/image_raw',
          'camera_info_topic': 'usb_cam/camera_info', 'camera_width': 320, 'camera_height': 240,
          'camera_rate': 15.0}


class Case(NamedTuple):
    """How the robots run. factor: that is wanted, 0 is as fast as possible."""

    title: str
    factor: float
    is_watched: bool = False
    has_cameras: bool = False


CASES = (Case('free run, no subscriber', 0.0),
         Case('free run, all topics subscribed', 0.0, is_watched=True),
         Case('real time, all topics subscribed', 1.0, is_watched=True),
         Case('real time, camera 320x240 at 15 Hz and color_extract each', 1.0, has_cameras=True))


def _sample(case: Case, number: int) -> dict:
    """Return what drive_sample.py measures with a new simulator."""
    robots = ['/tb3_{}'.format(index) for index in range(number)]
    with Master() as master:
        pids = [master.start_simulator(
            real_time_factor=case.factor, several_robots=True,
            robots={robot[1:]: CAMERA if case.has_cameras else {} for robot in robots})]
        if case.has_cameras:
            pids += [master.start_script('color_img_recog.py', '__ns:=' + robot).pid
                     for robot in robots]
            wait_for(lambda: {robot + '/cmd_vel' for robot in robots}
                     <= {topic for topic, _ in master.server.getSystemState()[0]},
                     'the nodes color_extract')
        watched = ['/clock', '/tf', *('{}/{}'.format(robot, topic)
                                      for robot in robots for topic in TOPICS)]
        return run_script('drive_sample.py', {
            'robots': robots, 'pids': pids, 'seconds': SECONDS, 'turns': 1, 'bare': False,
            'subscribers': [watched if case.is_watched else []]}, env=master.env)[0][0]


def _samples(case: Case) -> Samples:
    return {'{} robots'.format(number): [_sample(case, number)] for number in NUMBERS}


def benchmark() -> Benchmark:
    """Return what the robots cost."""
    return Benchmark('several robots in turtlebot3_world', {
        case.title: partial(_samples, case) for case in CASES}, (
            Column('steps/s', 'steps_per_s', '{:.0f}'), Column('real time', 'factor'),
            Column('CPU of a core', 'cpu_share', '{:.1%}'),
            Column('CPU of a step of a robot, us', 'robot_step_us', '{:.1f}'),
            Column('memory of all, MB', 'memory_mb', '{:.0f}')))
