"""Tools for tests of the simulator node: its inputs, its messages and its processes."""
import contextlib
import itertools
import os
import re
import select
import threading

import genpy
import numpy as np
from geometry_msgs.msg import Twist, Vector3
from roslib.message import get_message_class

from img_recog_helpers import wire
from img_recog_helpers.process_table import descendants
from img_recog_helpers.waiting import DEADLINE_S, wait_for

# what these warn of, each test notices by itself if it matters: images or messages are missing
_OF_A_BUSY_MACHINE = ('this machine is too slow', 'the simulation waits for images',
                      'waiting for the process that draws',
                      # rospy's, of a client that has ended
                      'Inbound TCP/IP connection failed')
_POLL_S = 0.02
_CONNECT_POLL_S = 0.1       # the master takes 3 ms for each try
_numbers_of_nodes = itertools.count()
BURGER = os.path.join(os.path.dirname(__file__), '..', '..', 'urdf', 'turtlebot3_burger.urdf')


def burger(addition=''):
    """Return the URDF of the burger with text added at its end."""
    with open(BURGER) as file:
        return file.read().replace('</robot>', addition + '</robot>')


def with_tags(**tags):
    """Return the URDF of the burger with other texts in tags of its drive, by name."""
    text = burger()
    for tag in tags.items():
        text, count = re.subn('<{0}>.*?</{0}>'.format(tag[0]), '<{0}>{1}</{0}>'.format(*tag), text)
        assert count == 1, tag
    return text


class Echo:
    """Reads a topic in a thread: `rostopic echo` takes a second to start.

    rows: a list of numbers for each message, in order; times are in ns.
    """

    def __init__(self, ros, path, buffer_bytes=None):
        """path: a topic that may not be there yet, and fields of its messages, as in rostopic.

        buffer_bytes: of what has arrived and is not read, by default as large as the system likes.
        """
        self.rows, self._buffer_bytes = [], buffer_bytes
        self._master, self._path = ros.master_uri, path
        self._caller = '/echo_{}'.format(next(_numbers_of_nodes))
        self._has_ended, self._may_read = threading.Event(), threading.Event()
        self.is_connected = threading.Event()
        self._may_read.set()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        ros.stack.callback(self.close)

    def _run(self):
        while not self._has_ended.wait(_CONNECT_POLL_S):
            with contextlib.suppress(*wire.ERRORS):
                self._read()

    def _read(self):
        types = dict(wire.call(self._master, 'getTopicTypes'))
        publishers = dict(wire.call(self._master, 'getSystemState')[0])
        topic = max((name for name in publishers if (self._path + '/').startswith(name + '/')),
                    default='', key=len)
        data_class = get_message_class(types.get(topic, ''))
        if data_class is None:
            return
        with contextlib.closing(wire.Subscription(
                self._master, publishers[topic][0], topic, data_class, DEADLINE_S,
                self._buffer_bytes, self._caller)) as messages:
            self.is_connected.set()
            while not self._has_ended.is_set():
                if self._may_read.wait(_POLL_S) and select.select([messages.sock], [], [],
                                                                  _POLL_S)[0]:
                    self.rows += [self.row(msg, self._path[len(topic):])
                                  for msg in messages.read()]

    @staticmethod
    def row(msg, fields):
        """Return what is stored for a message."""
        for name, index in re.findall(r'/(\w+)(?:\[(\d+)\])?', fields):
            msg = getattr(msg, name)[int(index)] if index else getattr(msg, name)
        return list(_numbers(msg))

    def hang(self, is_hanging):
        """Stop reading, or go on."""
        (self._may_read.clear if is_hanging else self._may_read.set)()

    def wait(self, accept, what):
        """Wait until `accept` returns True for the newest row; return it."""
        def newest():
            rows = self.rows[-1:]
            return rows if rows and accept(*rows[-1]) else None
        return wait_for(newest, lambda: '{}; the newest are {}'.format(what, self.rows[-3:]))[0]

    def wait_more(self, count):
        """Wait until there are `count` more rows than now; return all."""
        goal = len(self.rows) + count
        wait_for(lambda: len(self.rows) >= goal, lambda: '{} rows'.format(goal))
        return self.rows

    def close(self):
        self._has_ended.set()
        self._thread.join()


class Messages(Echo):
    """The messages themselves, instead of numbers."""

    @staticmethod
    def row(msg, fields):
        return msg


def _numbers(value):
    """Yield the numbers in a field of a message."""
    if isinstance(value, genpy.TVal):
        yield value.to_nsec()
    elif isinstance(value, genpy.Message):
        for name in value.__slots__:
            yield from _numbers(getattr(value, name))
    else:
        yield float(value)


def drive(ros, linear, angular=0.0):
    """Publish a command in m/s and rad/s, to each subscriber once; return the publisher."""
    command = Twist(Vector3(x=linear), Vector3(z=angular))
    publisher = wire.RawPublisher(ros.master_uri, '/cmd_vel', Twist,
                                  '/driver_{}'.format(next(_numbers_of_nodes)), first=command)
    ros.stack.callback(publisher.close)
    return publisher


def published(ros):
    """Return the topics that are published."""
    return {topic for topic, _ in ros.master().getSystemState('/test')[2][0]}


def complaints(node):
    """Return the warnings and errors of a simulator, except for those about a busy machine."""
    return [line for line in re.findall(r'\[(?:WARN|ERROR|FATAL)\].*', node.output)
            if not any(words in line for words in _OF_A_BUSY_MACHINE)]


def drawing(node):
    """Return the id of the drawing process of a simulator, or None."""
    return next((pid for pid, line in descendants(node.pid).items() if 'spawn_main' in line), None)


class Images(Echo):
    """The contents of the images of the view, instead of numbers."""

    def __init__(self, ros):
        super().__init__(ros, '/gazebo/view/image_raw')

    @staticmethod
    def row(msg, fields):
        """Return the header and where pixels of some colors are: their share and middle."""
        pixels = np.frombuffer(msg.data, np.uint8).reshape(msg.height, msg.width, 3)

        def found(low, high):
            rows, columns = np.nonzero(((pixels >= low) & (pixels <= high)).all(axis=2))
            middle = [float(columns.mean()), float(rows.mean())] if len(rows) else None
            return {'share': len(rows) / pixels[..., 0].size, 'middle': middle}
        return {'stamp': msg.header.stamp.to_sec(), 'frame': msg.header.frame_id,
                'size': [msg.width, msg.height, msg.step], 'encoding': msg.encoding,
                'green': found((0, 90, 0), (60, 255, 60)), 'white': found((205,) * 3, (255,) * 3),
                'red': found((150, 0, 0), (255, 30, 30)),
                'wall': found((20,) * 3, (90,) * 3), 'dark': found((0,) * 3, (130,) * 3)}

    def wait(self, accept=lambda image: True, count=1):
        """Wait for `count` more images and for one that `accept` returns True for; return it."""
        goal = len(self.rows) + count

        def newest():
            images = self.rows[-1:]
            return images if len(self.rows) >= goal and accept(images[-1]) else None
        return wait_for(newest, lambda: 'an image; the newest: {}'.format(self.rows[-1:]))[0]


def wait_standing(place):
    """Wait until x of an Echo differs by less than 1 mm in 30 rows, one second; return the last.
    """
    def last():
        rows = place.rows[-30:]
        is_standing = len(rows) == 30 and np.ptp([x for x, *_ in rows]) < 1e-3
        return is_standing and rows[-1]
    return wait_for(last, lambda: 'the robot to stand: {}'.format(place.rows[-30:]))
