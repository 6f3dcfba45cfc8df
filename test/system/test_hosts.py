"""The demo on three hosts: simulator, camera, recognition. The network is cut, late and lossy."""
import contextlib
import json
import sys

import cv2
import numpy as np
import pytest

from img_recog_helpers import hosts, watch_robot
from img_recog_helpers.hosts import Hosts
from img_recog_helpers.waiting import stretch, wait_for

REASON = hosts.reason_without()
pytestmark = pytest.mark.skipif(bool(REASON), reason=REASON)

SIZE, RATE_HZ, CARD_FRAMES = (320, 240), 15.0, 30
SPEED = 0.2
COLORS = 'blue_linear_x: {0}\nred_linear_x: -{0}\n'.format(SPEED)
STANDS = 0.01               # m/s
TIMEOUT_S = 0.5             # cmd_vel_timeout of the demo
BRAKING_S = 0.3             # from 0.2 m/s, with 1 m/s2, and the period of the watch
CUT_S, BACK_S = 5.0, 5.0
NO_WINDOWS = ['gui:=false', 'image_view:=false', 'web:=false']
LAST_NODES = {'simulator': 'robot_state_publisher', 'camera': 'usb_cam',
              'recognition': 'color_extract'}
PARTS = {'simulator': ['camera:=none', 'recognition:=false', 'teleop:=false', 'world:=empty'],
         'camera': ['simulator:=false', 'recognition:=false', 'teleop:=false'],
         'recognition': ['simulator:=false', 'camera:=none', 'teleop:=false']}


class Network:
    """The parts of the demo, each on its host."""

    def __init__(self, ros, folder, hosts_, transport):
        self._ros, self.hosts, self._lines = ros, hosts_, 0
        film, colors = folder / 'cards.avi', folder / 'colors.yaml'
        write_film(str(film))
        colors.write_text(COLORS + 'image_transport: {}\n'.format(transport))
        more = {'simulator': [], 'camera': ['camera:={}'.format(film)],
                'recognition': ['colors:={}'.format(colors)]}
        for name, arguments in PARTS.items():
            self._run(name, 'roslaunch', *(['-p', '11311'] if name == 'simulator' else []),
                      'img_recog', 'demo.launch', 'use_sim_time:=true', *NO_WINDOWS, *arguments,
                      *more[name]).wait_output(r'process\[{}-\d+\]: started'.format(
                          LAST_NODES[name]))
        self._watch = self._run('simulator', sys.executable, watch_robot.__file__)
        self.wait_follows()

    def _run(self, name, *command):
        env = dict(self._ros.env, ROS_IP=self.hosts.address(name), ROS_MASTER_URI=(
            'http://{}:11311'.format(self.hosts.address('simulator'))))
        env.pop('ROS_HOSTNAME')
        return self._ros.start(*self.hosts.command(name, *command), env=env)

    def states(self):
        """Return all that the watch has printed, in order."""
        return [json.loads(line) for line in self._watch.output.split('\n')[:-1]
                if line.startswith('{')]

    def now(self):
        """Return the newest state, after waiting for it."""
        count = len(self.states())
        wait_for(lambda: len(self.states()) > count, 'the watch')
        return self.states()[-1]

    def wait_follows(self, since=0.0):
        """Wait until the robot has gone forward and back after a time; return when it moved."""
        def moved():
            later = [state for state in self.states() if state['wall_s'] > since]
            ways = {np.sign(state['speed']) for state in later
                    if abs(state['speed']) > 0.75 * SPEED}
            return ways == {1.0, -1.0} and later
        later = wait_for(moved, lambda: 'the robot to follow: {}'.format(self.states()[-3:]))
        return next(state['wall_s'] for state in later if abs(state['speed']) > STANDS)


def write_film(path):
    """Write a film of a blue card and a red one, 2 s each, as noisy as a camera."""
    writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), RATE_HZ, SIZE)
    noise = np.random.RandomState(1)
    for card in ((215, 70, 25), (60, 25, 215)):
        for _ in range(CARD_FRAMES):
            frame = np.full((SIZE[1], SIZE[0], 3), 170, np.uint8)
            frame[60:180, 80:240] = card
            grain = noise.randint(-8, 9, frame.shape, np.int16)
            writer.write(np.clip(frame + grain, 0, 255).astype(np.uint8))
    writer.release()


@pytest.fixture
def network(ros, tmp_path):
    """A function that starts the parts, with an impairment of the host of the recognition."""
    with contextlib.ExitStack() as stack:
        made = Hosts(*PARTS)
        stack.callback(made.close)
        stack.callback(ros.close)       # first

        def start(transport, **impairment):
            if impairment:
                made.impair('recognition', **impairment)
            return Network(ros, tmp_path, made, transport)
        yield start


def test_a_cut_cable_stops_the_robot_and_it_follows_again(network):
    three = network('raw')
    three.hosts.plug('recognition', False)
    cut_s, busy = three.now()['wall_s'], stretch()
    limit_s = (TIMEOUT_S + BRAKING_S) * busy
    wait_for(lambda: three.now()['wall_s'] > cut_s + CUT_S * busy, 'the end of the cut')
    three.hosts.plug('recognition', True)
    healed_s = three.now()['wall_s']
    during = [state for state in three.states() if cut_s + limit_s < state['wall_s'] < healed_s]
    assert len(during) > 20
    assert max(abs(state['speed']) for state in during) < STANDS, (limit_s, during[:5])
    assert three.wait_follows(healed_s) - healed_s < BACK_S * max(busy, stretch())


def test_late_and_lossy_it_follows_with_the_newest_frame(network):
    three = network('compressed', delay_s=0.05, loss=0.01)
    begin = three.now()
    three.wait_follows(begin['wall_s'])
    wait_for(lambda: three.now()['frames'] > begin['frames'] + 60, lambda: three.states()[-1])
    ages = [state['age_s'] for state in three.states() if state['frames'] > begin['frames']]
    # one way of the image and one of the result, and what is sent again after a loss
    assert 0.1 < np.median(ages) < 0.6 * stretch(), ages
    # frames do not wait in a queue: the last ones are not older than the first ones
    third = len(ages) // 3
    assert np.median(ages[-third:]) < np.median(ages[:third]) + 0.3 * stretch(), ages
