"""The program plot: what it draws of bags and of the running system, and what is refused."""
import shutil
from types import SimpleNamespace

import cv2
import genpy
import numpy as np
import pytest
import rosbag
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Header, String

from img_recog.conversions import color_detection_msgs, plane_msgs, twist_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay import figure, plot_job
from img_recog.replay.plot_job import drive_of
from img_recog.recordings.bag_file import BagFile
from img_recog.replay.plot_data import PlotColor
from img_recog_helpers.films import SQUARE
from img_recog_helpers.xmlrpc_server import XmlRpcServer

pytestmark = pytest.mark.usefixtures('handlers_as_before')
COLORS = with_colors()().colors


def odometry(x, y, speed=0.5):
    msg = Odometry()
    msg.pose.pose = plane_msgs.pose_to_msg(PlanePose(x, y, 0.25), Header()).pose
    msg.twist.twist = twist_msgs.to_msg(speed, 0.1)
    return msg


def detection(**areas):
    return color_detection_msgs.to_msg(list(areas), list(areas.values()), [None] * len(areas),
                                       Header())


def write(path, *recorded):
    """Write a bag of (topic, message, time in s)."""
    with rosbag.Bag(str(path), 'w') as bag:
        for topic, msg, time_s in recorded:
            bag.write(topic, msg, genpy.Time.from_sec(time_s))
    return path


class OfTwoSenders(BagFile):
    """With the sender of each message: the Python API writes only one for a topic."""

    def read_messages(self, *words, **options):
        for topic, msg, time, _ in super().read_messages(*words, **options):
            yield topic, msg, time, {
                'callerid': b'/teleop' if time.to_sec() == 10.5 else b'/color_extract'}


@pytest.fixture
def path(tmp_path):
    """A bag of a robot that drives 0.2 m, and is then moved."""
    return write(
        tmp_path / 'in.bag',
        ('/gazebo/world_outlines', plane_msgs.outlines_to_msg(
            [SQUARE], PlanePose(0.0, 0.0, 0.0), 'odom', genpy.Time(1)), 9.0),
        ('/odom', odometry(1.0, 2.0), 10.0), ('/odom', odometry(1.2, 2.0), 10.5),
        ('/odom', odometry(3.0, 0.0), 11.0), ('/odom', odometry(np.nan, 0.0), 11.1),
        ('/odom', odometry(3.0, 0.0, 1.7e308), 11.2),
        ('/cmd_vel', twist_msgs.to_msg(10.0), 10.25),
        ('/cmd_vel', Twist(), 10.5), ('/cmd_vel', Twist(), 10.75),
        ('/color_detection', detection(blue=70, white=5), 10.5), ('/chatter', String('x'), 12.0))


@pytest.fixture
def plot(capsys, caplog):
    """A function that runs the program; it returns the exit code, the output and the log."""
    def run(*arguments):
        code = plot_job.main([str(argument) for argument in arguments])
        assert {each.name for each in caplog.records} <= {'plot.py'}
        return code, capsys.readouterr().out, ''.join(caplog.messages)
    return run


def test_the_data_of_a_drive(path):
    with OfTwoSenders(str(path)) as bag:
        data, _ = drive_of('in.bag', bag, '/odom', COLORS)
    assert data.motion == pytest.approx(np.array([
        (0.0, 1.0, 2.0, 0.25, 0.5, 0.1), (0.5, 1.2, 2.0, 0.25, 0.5, 0.1),
        (1.0, 3.0, 0.0, 0.25, 0.5, 0.1)]))
    assert data.moved == [2] and data.end_s == pytest.approx(1.2)
    # a sender of zeros alone is idle
    assert data.commands == pytest.approx(np.array([(0.25, 10.0, 0.0), (0.75, 0.0, 0.0)]))
    assert data.idle == pytest.approx(np.array([(0.5, 0.0, 0.0)]))
    assert data.areas == pytest.approx(np.array([(0.5, 70, 5)]))
    assert data.colors == [COLORS[0], PlotColor('white', (50, 50))]
    assert [outline.tolist() for outline in data.outlines] == [SQUARE.tolist()]


def test_a_picture_of_a_bag(path, plot, tmp_path):
    out = tmp_path / 'out.png'
    assert plot(path, out) == (0, '{}: 1.2 s, 3 poses, 3 commands\n'.format(out), '')
    assert cv2.imread(str(out)).shape == (900, 1400, 3)


def test_a_bag_with_odometry_alone_and_without_slashes(plot, tmp_path):
    path, out = write(tmp_path / 'in.bag', ('odom', odometry(1.0, 2.0), 10.0)), tmp_path / 'o.png'
    assert plot(path, out) == (0, '{}: 0.0 s, 1 pose, 0 commands\n'.format(out), '')


def test_one_of_several_robots(plot, tmp_path):
    path = write(tmp_path / 'in.bag', *(
        ('/tb3_{}/odom'.format(number), odometry(1.0, 2.0), 10.0 + time_s)
        for number in range(2) for time_s in range(1 + number)))
    assert plot(path, tmp_path / 'o.png')[2] == (
        'in.bag has no odometry on /odom; there is /tb3_0/odom, /tb3_1/odom; choose a robot with '
        '--robot, as tb3_0 for /tb3_0/odom')
    assert ', 2 poses, ' in plot(path, tmp_path / 'o.png', '--robot', '/tb3_1')[1]


@pytest.mark.parametrize('content, problem', [
    (None, 'cannot read {}: no such file; give a bag, as of ./run demo record:=FILE, or none'),
    (b'junk', 'cannot read {} as a bag: '),
    ([('/chatter', String('x'), 1.0)],
     'in.bag has no odometry on /odom; there is none of type nav_msgs/Odometry; record it'),
    ([('/odom', odometry(np.nan, 0.0), 1.0)], 'in.bag has no usable message on /odom; record')])
def test_a_bag_that_is_refused(plot, tmp_path, content, problem):
    path = tmp_path / 'in.bag'
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content:
        write(path, *content)
    code, out, log = plot(path, tmp_path / 'out.png')
    assert (code, out) == (1, '') and log.startswith(problem.format(path)) and '\n' not in log
    assert not (tmp_path / 'out.png').exists()


@pytest.mark.parametrize('uri', ['http://127.0.0.1:9', 'nonsense', 'http://127.0.0.1:x'])
def test_without_a_master(plot, tmp_path, monkeypatch, uri):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    code, _, log = plot(tmp_path / 'out.png')
    assert code == 1 and log.startswith('no master answers at {}: '.format(uri))
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def running(tmp_path, monkeypatch):
    """A function that starts a master with these parameters of color_extract.

    Instead of a recording there is a bag. Returns what is drawn, which topics are recorded, and
    for how many ticks.
    """
    recorded = write(tmp_path / 'new.bag', ('/tb3/odom', odometry(1.0, 2.0), 10.0),
                     ('/tb3/color_detection', detection(blue=70), 10.5))
    drawn, topics, ticks, servers = [], [], [], []

    def record(path, names):
        topics.extend(names)
        return SimpleNamespace(
            path=path, stop=lambda: shutil.copy(str(recorded), path),
            check=lambda: ticks.append('') or len(ticks) == 3)         # at its largest size

    def start(parameters):
        def answer(method, node, name):
            if method == 'getPublishedTopics':
                return 1, '', [['/tb3/odom', 'nav_msgs/Odometry'], ['/x', 'std_msgs/String'],
                               ['/lab/gazebo/world_outlines', 'any']]
            assert (method, name) == ('getParam', '/tb3/color_extract')
            return (-1, 'none', 0) if parameters is None else (1, '', parameters)
        servers.append(XmlRpcServer(dispatch=answer))
        monkeypatch.setenv('ROS_MASTER_URI', servers[0].uri)
        return drawn, topics, ticks
    monkeypatch.setattr(plot_job, 'BagRecording', record)
    monkeypatch.setattr(figure, 'draw', lambda file, title, data: drawn.append((title, data)))
    yield start
    for server in servers:
        server.stop()


@pytest.mark.parametrize('parameters, words, limit_px, warning', [
    ({'blue_area_limit': 7}, [], 7, ''), (None, [], 1000, ''),
    ({'blue_area_limit': -7}, [], 1000, 'the limits are those of the article: /tb3/color_extract'),
    ({'blue_area_limit': 7}, ['--colors', 'mine.yaml', '--duration', '0.1'], 9, '')])
def test_the_running_system(plot, running, tmp_path, monkeypatch, parameters, words, limit_px,
                            warning):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'mine.yaml').write_text('blue_area_limit: 9\n')
    drawn, topics, ticks = running(parameters)
    code, out, log = plot('out.png', '--robot', 'tb3', *words)
    assert (code, out) == (0, 'out.png: 0.5 s, 1 pose, 0 commands\n')
    assert log.startswith(warning) and bool(log) == bool(warning)
    assert len(ticks) == (1 if words else 3)
    assert topics == ['/tb3/odom', '/tb3/cmd_vel', '/tb3/color_detection',
                      '/lab/gazebo/world_outlines']
    (title, data), = drawn
    assert title == 'Drive of the running system, 0.5 s'
    assert [color.area_limit_px for color in data.colors] == [limit_px]


@pytest.mark.parametrize('words, problem', [
    (['out.jpg'], "got 'out.jpg', expected FILE.png"), ([], 'FILE.png'),
    (['out.png', '--duration', '0'], "got '0', expected more than 0"),
    (['out.png', '--duration', 'nan'], "got 'nan', expected more than 0")])
def test_options_that_are_refused(words, problem, capsys):
    with pytest.raises(SystemExit):
        plot_job.main(words)
    error = capsys.readouterr().err
    assert error.startswith('usage: plot.py ') and problem in error
