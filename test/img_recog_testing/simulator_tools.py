"""Tools for tests of the simulator node: its inputs, its messages and its processes."""
import json
import os
import re
import sys

from img_recog_testing.process_table import descendants
from img_recog_testing.waiting import wait_for

# what these warn of, each test notices by itself if it matters: images or messages are missing
_OF_A_BUSY_MACHINE = ('this machine is too slow', 'the simulation waits for images',
                      'it has sent no complete header')
BURGER = os.path.join(os.path.dirname(__file__), '..', '..', 'urdf', 'turtlebot3_burger.urdf')


def burger(addition=''):
    """Return the URDF of the burger with text added at its end."""
    with open(BURGER) as file:
        return file.read().replace('</robot>', addition + '</robot>')


class Echo:
    """The numbers in the messages of a topic, by `rostopic echo -p`: a row for each message."""

    def __init__(self, ros, topic):
        self._process = ros.start('rostopic', 'echo', '-p', topic)
        self.pid = self._process.pid

    @property
    def rows(self):
        _, _, table = self._process.output.partition('%time')
        # rostopic may also print a warning while it waits for the first message
        lines = [line for line in table.split('\n')[1:-1] if line[:1].isdigit()]
        return [[float(word) for word in line.split(',')[1:]] for line in lines]

    def wait(self, accept, what):
        """Wait until `accept` returns True for the newest row; return it."""
        def newest():
            rows = self.rows
            return rows[-1:] if rows and accept(*rows[-1]) else None
        return wait_for(newest, lambda: '{}; the newest are {}'.format(what, self.rows[-3:]))[0]

    def wait_more(self, count):
        """Wait until there are `count` more rows than now; return all."""
        goal = len(self.rows) + count
        wait_for(lambda: len(self.rows) >= goal, lambda: '{} rows'.format(goal))
        return self.rows

    def close(self):
        self._process.close()


def drive(ros, linear, angular=0.0):
    """Publish a command in m/s and rad/s; return the process that does so."""
    return ros.start('rostopic', 'pub', '/cmd_vel', 'geometry_msgs/Twist',
                     '{{linear: {{x: {}}}, angular: {{z: {}}}}}'.format(linear, angular))


def call(ros, service):
    assert ros.run('rosservice', 'call', '/gazebo/' + service).strip() == ''


def complaints(node):
    """Return the warnings and errors of a simulator, except for those about a busy machine."""
    return [line for line in re.findall(r'\[(?:WARN|ERROR|FATAL)\].*', node.output)
            if not any(words in line for words in _OF_A_BUSY_MACHINE)]


def drawing(node):
    """Return the id of the drawing process of a simulator, or None."""
    return next((pid for pid, line in descendants(node.pid).items() if 'spawn_main' in line), None)


IMAGES = '''
import json
import numpy, rospy
from sensor_msgs.msg import Image

def show(msg):
    pixels = numpy.frombuffer(msg.data, numpy.uint8).reshape(msg.height, msg.width, 3)
    def found(low, high):
        rows, columns = numpy.nonzero(((pixels >= low) & (pixels <= high)).all(axis=2))
        middle = [float(columns.mean()), float(rows.mean())] if len(rows) else None
        return {'share': len(rows) / pixels[..., 0].size, 'middle': middle}
    print(json.dumps({
        'stamp': msg.header.stamp.to_sec(), 'frame': msg.header.frame_id,
        'size': [msg.width, msg.height, msg.step], 'encoding': msg.encoding,
        'green': found((0, 90, 0), (60, 255, 60)), 'white': found((205,) * 3, (255,) * 3),
        'red': found((150, 0, 0), (255, 30, 30)),
        'wall': found((20,) * 3, (90,) * 3), 'dark': found((0,) * 3, (130,) * 3)}), flush=True)

rospy.init_node('images', anonymous=True)
rospy.Subscriber('/gazebo/view/image_raw', Image, show, queue_size=1, buff_size=1 << 24)
rospy.spin()
'''


class Images:
    """The contents of the images of the view."""

    def __init__(self, ros):
        self._process = ros.start(sys.executable, '-c', IMAGES)

    @property
    def all(self):
        return [json.loads(line) for line in self._process.output.split('\n')[:-1]
                if line.startswith('{')]

    def wait(self, accept=lambda image: True, count=1):
        """Wait for `count` more images and for one that `accept` returns True for; return it."""
        goal = len(self.all) + count

        def newest():
            images = self.all
            return images[-1] if len(images) >= goal and accept(images[-1]) else None
        return wait_for(newest, lambda: 'an image; the newest: {}\n{}'.format(
            self.all[-1:], self._process.output[-500:]))

    def close(self):
        self._process.close()


def standing(rows):
    """Return whether x differs by less than 1 mm in 30 rows, which are one second."""
    return len(rows) == 30 and max(x for x, *_ in rows) - min(x for x, *_ in rows) < 1e-3
