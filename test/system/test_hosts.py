"""The demo on three hosts: simulator, camera, recognition. The network is cut, late and lossy.

The hosts are network namespaces of this machine; they need the rights of root.
"""
import contextlib
import json
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

from img_recog_helpers import relay, watch_robot
from img_recog_helpers.waiting import wait_for

_SUBNET = '10.77.0.'
_SWITCH = 'switch'
SIZE, RATE_HZ, CARD_FRAMES = (320, 240), 15.0, 30
SPEED = 0.2
COLORS = 'blue_linear_x: {0}\nred_linear_x: -{0}\n'.format(SPEED)
STANDS = 0.01               # m/s
CUT_STATES = 50             # of the watch: 5 s; without a command the robot stops after 0.5 s
MAX_AGE_S = 0.6             # of a frame: two ways, and what is sent again after a loss
NO_WINDOWS = ['gui:=false', 'image_view:=false', 'web:=false']
LAST_NODES = {'simulator': 'robot_state_publisher', 'camera': 'usb_cam',
              'recognition': 'color_extract'}
PARTS = {'simulator': ['camera:=none', 'recognition:=false', 'teleop:=false', 'world:=empty'],
         'camera': ['simulator:=false', 'recognition:=false', 'teleop:=false'],
         'recognition': ['simulator:=false', 'camera:=none', 'teleop:=false']}


def _run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False,
                          universal_newlines=True)


def reason_without():
    """Return why there can be no hosts here, '' if they can be made."""
    name = 'irt{}x'.format(os.getpid())
    try:
        made = _run('ip', 'netns', 'add', name)
    except OSError as error:
        return 'ip: {}'.format(error.strerror)
    if made.returncode:
        return 'no network namespace: ' + made.stderr.strip()
    try:
        found = _run('ip', '-n', name, 'link', 'add', 'br0', 'type', 'bridge')
        return found.stderr.strip() and 'no bridge: ' + found.stderr.strip()
    finally:
        _run('ip', 'netns', 'del', name)


REASON = reason_without()
pytestmark = pytest.mark.skipif(bool(REASON), reason=REASON)


class Hosts:
    """Hosts that reach one another through a switch, and nothing else.

    names: of the hosts; their addresses are 10.77.0.1 and so on, in their namespaces only.
    """

    def __init__(self, *names):
        self.names = names
        self._prefix = 'irt{}'.format(os.getpid())
        self._relay = None
        self._made = []
        try:
            self._make()
        except Exception:
            self.close()
            raise

    def _make(self):
        self._add(_SWITCH)
        self._ip(_SWITCH, 'link', 'add', 'br0', 'type', 'bridge')
        self._ip(_SWITCH, 'link', 'set', 'br0', 'up')
        for number, name in enumerate(self.names):
            self._add(name)
            self._ip(name, 'link', 'add', 'eth0', 'type', 'veth', 'peer', 'name',
                     'port{}'.format(number), 'netns', self._namespace(_SWITCH))
            self._ip(_SWITCH, 'link', 'set', 'port{}'.format(number), 'master', 'br0', 'up')
            self._ip(name, 'address', 'add', self.address(name) + '/24', 'dev', 'eth0')
            self._ip(name, 'link', 'set', 'eth0', 'up')

    def _add(self, name):
        self._check(_run('ip', 'netns', 'add', self._namespace(name)))
        self._made.append(name)
        self._ip(name, 'link', 'set', 'lo', 'up')

    def _namespace(self, name):
        return '{}-{}'.format(self._prefix, name)

    def address(self, name):
        """Return the address of a host."""
        return _SUBNET + str(1 + self.names.index(name))

    def command(self, name, *words):
        """Return the command that runs a program on a host."""
        return ['ip', 'netns', 'exec', self._namespace(name), *words]

    def plug(self, name, is_in):
        """Plug the cable of a host in, or pull it out."""
        self._ip(_SWITCH, 'link', 'set', 'port{}'.format(self.names.index(name)),
                 'up' if is_in else 'down')

    def impair(self, name, delay_s, loss):
        """Delay all that a host sends and receives, and lose a share of the packets.

        By a program that passes the packets on: not every kernel has netem.
        """
        self._ip(name, 'link', 'del', 'eth0')       # its other end too
        self._relay = subprocess.Popen(
            self.command(_SWITCH, sys.executable, relay.__file__, 'tap0', self._namespace(name),
                         'eth0', str(delay_s), str(loss)))
        wait_for(lambda: not _run('ip', '-n', self._namespace(name), 'link', 'show', 'eth0')
                 .returncode, 'the relay')
        self._ip(_SWITCH, 'link', 'set', 'tap0', 'master', 'br0', 'up')
        self._ip(name, 'address', 'add', self.address(name) + '/24', 'dev', 'eth0')
        self._ip(name, 'link', 'set', 'eth0', 'up')

    def _ip(self, name, *words):
        self._check(_run('ip', '-n', self._namespace(name), *words))

    @staticmethod
    def _check(result):
        assert result.returncode == 0, '{}: {}'.format(' '.join(result.args), result.stderr)

    def close(self):
        """Remove everything; the programs must have ended."""
        if self._relay is not None:
            self._relay.terminate()
            self._relay.wait()
        for name in self._made:
            _run('ip', 'netns', 'del', self._namespace(name))


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
        """Wait until the robot has gone forward and back after a time."""
        def moved():
            later = [state for state in self.states() if state['wall_s'] > since]
            ways = {np.sign(state['speed']) for state in later
                    if abs(state['speed']) > 0.75 * SPEED}
            return ways == {1.0, -1.0}
        wait_for(moved, lambda: 'the robot to follow: {}'.format(self.states()[-3:]))


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
    begin = len(three.states())
    # longer than the robot takes from a blue card to a red one
    wait_for(lambda: len(three.states()) > begin + CUT_STATES and all(
        abs(state['speed']) < STANDS for state in three.states()[-CUT_STATES:]),
        lambda: 'the robot to stand: {}'.format(three.states()[-3:]))
    three.hosts.plug('recognition', True)
    three.wait_follows(three.now()['wall_s'])


def test_late_and_lossy_it_follows_with_the_newest_frame(network):
    three = network('compressed', delay_s=0.05, loss=0.01)
    begin = three.now()
    three.wait_follows(begin['wall_s'])
    wait_for(lambda: three.now()['frames'] > begin['frames'] + 60, lambda: three.states()[-1])
    ages = [state['age_s'] for state in three.states() if state['frames'] > begin['frames']]
    # one way of the image and one of the result
    assert np.median(ages) > 0.1, ages
    # frames do not wait in a queue, where all of the last ones would be old
    assert min(ages[-len(ages) // 3:]) < MAX_AGE_S, ages
