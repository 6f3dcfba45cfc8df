"""Hostile geometry_msgs/Twist: every field and the raw bytes, in process and over the wire."""
import math
import random
import struct
import time
from typing import Dict, List

import numpy as np
from genpy import DeserializationError
from geometry_msgs.msg import Twist
from hypothesis import strategies
from nav_msgs.msg import Odometry

from img_recog.conversions import twist_msgs
from img_recog.conversions.twist_msgs import TwistError
from img_recog.simulation.simulation_settings import DriveSettings
from img_recog_helpers import robots
from img_recog_helpers.process_table import usage
from img_recog_helpers import wire
from img_recog_helpers.reliability import hostile
from img_recog_helpers.reliability.nodes import Nodes
from img_recog_helpers.waiting import wait_for

_FIELDS = tuple((part, axis) for part in ('linear', 'angular') for axis in 'xyz')
_STRUCT = struct.Struct('<6d')
_EXTREME = (0.0, -0.0, math.nan, math.inf, -math.inf, 1.7e308, -1.7e308, 5e-324, 1e-30, 0.2, 1e30)
_MAX_SPEED, _MAX_TURN = 0.22, 2.84
_BATCH = 300            # messages over the wire


class _Check:
    """Gives Twists to the conversion, and what it accepts to a simulated robot."""

    def __init__(self, drive: DriveSettings):
        self._simulator = robots.assemble(drive=drive)
        self._robot = self._simulator.robots[0]
        self.accepted = self.refused = self.undecodable = 0

    def example(self, pool: List[float], rng: random.Random) -> None:
        for _ in range(hostile.PER_EXAMPLE):
            values = [rng.choice(pool if rng.random() < 0.5 else _EXTREME) if rng.random() < 0.6
                      else rng.uniform(-3, 3) for _ in _FIELDS]
            data = _STRUCT.pack(*values)
            if rng.random() < 0.3:
                data = hostile.damaged(data, rng)
            self._message(data)
        self._simulator.advance(10)
        motion = self._robot.body.motion()
        for values in (motion.position, motion.orientation, motion.linear, motion.angular):
            assert np.isfinite(values).all(), motion
        # at most a little faster than the limit, when it slips or tilts
        assert abs(motion.linear[0]) < 2 * _MAX_SPEED, motion

    def _message(self, data: bytes) -> None:
        try:
            msg = Twist().deserialize(data)
        except DeserializationError:
            assert len(data) < _STRUCT.size
            self.undecodable += 1
            return
        expected = _STRUCT.unpack(data[:_STRUCT.size])
        try:
            linear_x, angular_z, _ = twist_msgs.from_msg(msg)
        except TwistError as error:
            assert not all(map(math.isfinite, expected)) and '\n' not in str(error)
            self.refused += 1
        else:
            assert all(map(math.isfinite, expected))
            assert (linear_x, angular_z) == (expected[0], expected[5])
            self._robot.command(linear_x, angular_z)
            self.accepted += 1


def in_process(count: int, seed: int) -> Dict[str, int]:
    """Give `count` Twists to the conversion and the simulation; return how many were accepted."""
    check = _Check(robots.burgers_drive(max_linear_velocity=_MAX_SPEED,
                                        max_angular_velocity=_MAX_TURN))
    hostile.explore(max(1, count // hostile.PER_EXAMPLE), seed,
                    strategies.lists(strategies.floats(), min_size=1, max_size=6), check.example)
    return {'accepted': check.accepted, 'refused': check.refused,
            'undecodable': check.undecodable}


def over_the_wire(count: int, seed: int, nodes: Nodes) -> Dict[str, int]:
    """Send `count` messages of any bytes to a running simulator, which has to obey afterwards."""
    rng = random.Random(seed)
    simulator = nodes.start_node('pybullet_sim.py', '_world:=empty', '_max_linear_velocity:=0.2')
    nodes.node_pid('/gazebo')
    publisher = wire.RawPublisher(nodes.master_uri, '/cmd_vel', Twist)
    try:
        wait_for(publisher.get_num_connections, 'the subscription of the simulator')
        _obey(nodes, publisher, 0.2)
        before = usage(simulator.pid)
        for begin in range(0, count, _BATCH):
            for _ in range(_BATCH * 2 // 3):
                assert publisher.send(wire.framed(_hostile(rng))) == 1, 'it has hung up'
            _noise(nodes, rng, _BATCH // 3)
            if begin % (4 * _BATCH) == 0:
                _obey(nodes, publisher, rng.choice((0.2, -0.2)))
        _obey(nodes, publisher, -0.2)
        wait_for(lambda: usage(simulator.pid).threads <= before.threads + 5,
                 lambda: 'the end of threads: {}'.format(usage(simulator.pid)))
        after = usage(simulator.pid)
        assert after.rss_mb < before.rss_mb + 50, after
    finally:
        publisher.close()
    assert simulator.is_running(), simulator.output[-3000:]
    return {'sent': count, 'rss_growth_mb': round(after.rss_mb - before.rss_mb)}


def _hostile(rng: random.Random) -> bytes:
    return _STRUCT.pack(*(rng.choice(_EXTREME) if rng.random() < 0.5 else rng.uniform(-9, 9)
                          for _ in _FIELDS))


def _noise(nodes: Nodes, rng: random.Random, count: int) -> None:
    """Send damaged messages by a publisher of their own.

    rospy does not find the next message after one that is too short: it drops the connection or
    what comes by it, but must not drop others.
    """
    publisher = wire.RawPublisher(nodes.master_uri, '/cmd_vel', Twist, '/noise')
    try:
        wait_for(publisher.get_num_connections, 'the subscription of the simulator')
        for _ in range(count):
            data = hostile.damaged(_hostile(rng), rng)
            if not publisher.send(data if rng.random() < 0.2 else wire.framed(data)):
                break
    finally:
        publisher.close()


def _obey(nodes: Nodes, publisher: wire.RawPublisher, speed: float) -> None:
    """Wait until the robot drives as commanded."""
    odometry = nodes.subscribe('/gazebo', '/odom', Odometry)
    try:
        def obeys():
            publisher.publish(twist_msgs.to_msg(speed))
            time.sleep(0.05)
            return any(abs(msg.twist.twist.linear.x - speed) < 0.02
                       and np.isfinite(msg.pose.pose.position.x) for msg in odometry.read())
        wait_for(obeys, lambda: 'a robot at {} m/s\n{}'.format(speed, nodes.output()[-2000:]))
    finally:
        odometry.close()
