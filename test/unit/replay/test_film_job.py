"""The program film: which messages of a bag are shown, what is refused, and signals."""
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import warnings

import genpy
import numpy as np
import pytest
import rosbag
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header, String
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import compressed_image_msgs, image_msgs, plane_msgs
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.replay import film_job
from img_recog_helpers.films import BLUE, ROBOT, SQUARE, card, center_of, frames_of

pytestmark = pytest.mark.usefixtures('handlers_as_before')


def message(msg_type, time_s):
    msg = msg_type()
    msg.header.stamp = genpy.Time.from_sec(time_s)
    return msg


def jpeg(time_s):
    return compressed_image_msgs.to_msg(card(), 'bgr8', Header(stamp=genpy.Time.from_sec(time_s)),
                                        CompressionSettings())


def record(path, robots):
    """Write a bag of half a second, like that of a demo, with an image for each third picture.

    robots: place (x, y), m, by namespace.
    """
    with rosbag.Bag(str(path), 'w') as file:
        file.write('/gazebo/world_outlines', plane_msgs.outlines_to_msg(
            [SQUARE], PlanePose(0.0, 0.0, 0.0), 'odom', genpy.Time(1)), genpy.Time(1))
        for tick in range(5):
            now = genpy.Time.from_sec(10.0 + tick / 10)
            scan = LaserScan(angle_min=0.0, angle_increment=0.5, range_min=0.1, range_max=3.0,
                             ranges=[1.0, float('inf'), float('nan'), 2.0])
            image = jpeg(now.to_sec())
            for namespace, place in robots.items():
                odometry = message(Odometry, now.to_sec())
                position = odometry.pose.pose.position
                position.x, position.y = place
                odometry.pose.pose.orientation.w = 1.0
                for topic, msg in (('odom', odometry), ('scan', scan), ('cmd_vel', Twist()),
                                   ('usb_cam/image_raw/compressed', image)):
                    file.write(namespace + topic, msg, now)
    return path


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    return record(tmp_path_factory.mktemp('recorded') / 'in.bag', {'/': (2.0, 2.0)})


@pytest.fixture
def bag(recorded, tmp_path):
    """A bag of one robot."""
    shutil.copy(str(recorded), str(tmp_path))
    return tmp_path / 'in.bag'


@pytest.fixture
def make(capsys):
    """A function that runs the program; it returns exit code and output."""
    def run(*arguments):
        code = film_job.main([str(argument) for argument in arguments])
        return code, capsys.readouterr()
    return run


@pytest.fixture
def refused(make, caplog, tmp_path):
    """A function that runs the program, which fails; it returns the one line of the log."""
    def run(*arguments):
        before = sorted(tmp_path.iterdir())
        assert make(*arguments)[0] == 1
        assert sorted(tmp_path.iterdir()) == before
        return ''.join(caplog.messages)
    return run


def test_a_film_of_a_bag(bag, tmp_path, make):
    out = tmp_path / 'out.mp4'
    code, output = make(bag, out)
    assert code == 0, output.err
    assert output.out == '{}: 0.4 s, 5 images of /usb_cam/image_raw/compressed\n'.format(out)
    frames, _ = frames_of(out)
    assert len(frames) == 13
    assert center_of(frames[-1][34:394, 740:1270], ROBOT, 40) == pytest.approx((265, 180), abs=12)
    assert center_of(frames[-1][34:394, 10:490], BLUE, 30) == pytest.approx((240, 180), abs=4)


@pytest.mark.parametrize('name, side', [('a', 1), ('b', -1)])
def test_of_several_robots_the_film_shows_that_of_the_images(tmp_path, make, name, side):
    path = record(tmp_path / 'in.bag', {'/a/': (1.0, 2.0), '/b/': (3.0, 2.0)})
    out = tmp_path / 'out.mp4'
    code, output = make(path, out, '--topic', '/{}/usb_cam/image_raw/compressed'.format(
        name))
    assert code == 0, output.err
    x, y = center_of(frames_of(out)[0][-1][34:394, 740:1270], ROBOT, 40)
    assert x == pytest.approx(265, abs=12) and (y - 180) * side > 40


def other_definition(msg_type):
    """Return a type of the same name with other fields, as of another version of ROS."""
    return type('Other', (String,), {'_type': msg_type._type})


ROBOT_TOPICS = [('/odom', Odometry), ('/scan', LaserScan), ('/cmd_vel', Twist),
                ('/gazebo/world_outlines', MarkerArray)]


@pytest.mark.parametrize('topic, msg_type', ROBOT_TOPICS)
def test_a_type_with_another_definition_is_ignored(tmp_path, make, caplog, topic, msg_type):
    with rosbag.Bag(str(tmp_path / 'in.bag'), 'w') as file:
        for time_s in (10.0, 10.1):
            now = genpy.Time.from_sec(time_s)
            file.write(topic, other_definition(msg_type)('x'), now)
            file.write('/usb_cam/image_raw', image_msgs.to_msg(card(), 'bgr8', Header(stamp=now)),
                       now)
    code, output = make(tmp_path / 'in.bag', tmp_path / 'out.mp4')
    assert code == 0, output.err
    assert [record.getMessage() for record in caplog.records] == [
        'the film does not show {} ({}): the message type has another definition in this '
        'ROS'.format(topic, msg_type._type)]


@pytest.mark.parametrize('namespace', ['/', '/other/'])
def test_a_second_definition_in_the_bag_is_ignored(bag, tmp_path, make, caplog, namespace):
    with rosbag.Bag(str(bag), 'a') as file:
        for topic, msg_type in [*ROBOT_TOPICS, ('/usb_cam/image_raw/compressed', Odometry)]:
            file.write(namespace.rstrip('/') + topic, other_definition(msg_type)('x'),
                       genpy.Time(10.2))
    code, output = make(bag, tmp_path / 'out.mp4')
    assert code == 0, output.err
    assert output.out.endswith(': 0.4 s, 5 images of /usb_cam/image_raw/compressed\n')
    assert len(caplog.records) == (namespace != '/')
    frames, _ = frames_of(tmp_path / 'out.mp4')
    assert center_of(frames[-1][34:394, 740:1270], ROBOT, 40) == pytest.approx((265, 180), abs=12)


def quarters(far, least):
    return {'angle_increment': math.pi / 2, 'range_min': least, 'range_max': far,
            'ranges': [1.0, math.nan, far, 2.0, -far]}


@pytest.mark.parametrize('fields, wanted', [
    *(({'angle_increment': 1.0, 'range_max': 9.0, 'ranges': [1.0, 2.0], **fields},
       np.empty((0, 2))) for fields in (
           {'angle_min': math.nan}, {'angle_increment': math.inf}, {'range_min': math.nan},
           {'range_max': math.nan}, {'range_max': 0.5})),
    (quarters(math.inf, 0.0), [(4.0, 4.0), (3.0, 2.0)]),
    (quarters(3e38, -3e38), [(4.0, 4.0), (3.0, 2.0)])])
def test_points_of_a_scan_that_can_be_drawn(fields, wanted):
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        points = film_job.scan_points(LaserScan(**fields), (3.0, 4.0, 0.0))
    assert points.shape == np.shape(wanted) and points == pytest.approx(np.array(wanted))


@pytest.mark.parametrize('bad', [math.nan, -math.inf, 1e300])
def test_numbers_that_cannot_be_drawn(bag, tmp_path, make, bad):
    odometry, twist = message(Odometry, 10.42), Twist()
    odometry.pose.pose.orientation.w = 1.0
    odometry.pose.pose.position.x = odometry.pose.pose.position.y = 2.0
    odometry.twist.twist.linear.x = twist.linear.x = bad
    outlines = plane_msgs.outlines_to_msg(
        [SQUARE], PlanePose(0.0, 0.0, 0.0), 'odom', genpy.Time(1))
    outlines.markers[-1].points[0].x = outlines.markers[-1].points[1].y = bad
    with rosbag.Bag(str(bag), 'a') as file:
        for topic, msg, time_s in [('/odom', odometry, 10.42), ('/cmd_vel', twist, 10.42),
                                   ('/usb_cam/image_raw/compressed', jpeg(10.5), 10.5),
                                   ('/gazebo/world_outlines', outlines, 0.5)]:
            file.write(topic, msg, genpy.Time.from_sec(time_s))
    with warnings.catch_warnings():
        warnings.simplefilter('error', RuntimeWarning)
        code, output = make(bag, tmp_path / 'out.mp4')
    assert code == 0, output.err
    assert len(frames_of(tmp_path / 'out.mp4')[0]) == 16


WANTED = '; give a bag with images, as of ./run demo record:=FILE'


def unusable():
    msg = image_msgs.to_msg(card(), 'bgr8', Header())
    msg.data = b'short'
    return msg


@pytest.mark.parametrize('content, problem', [
    (None, 'cannot read {}: no such file' + WANTED),
    ('in.bag.active', '{0} is not complete: there is {0}.active; stop the demo that'),
    (b'junk', 'cannot read {} as a bag: .*' + WANTED),
    ([('/chatter', String('hello'), 1.0)], '.* {} has no messages of type sensor_msgs/Image'),
    ([('/usb_cam/image_raw', unusable(), 1.0)],
     'no image on /usb_cam/image_raw in {} can be used; '),
    # the clock was set while it was recorded
    ([('/usb_cam/image_raw/compressed', jpeg(time_s), time_s) for time_s in (10.0, 10.1, 3.0e7)],
     '.*jump ahead by 3e\\+07 s at message 2; extract a part without jumps')])
def test_a_bag_that_is_refused(tmp_path, refused, content, problem):
    path = tmp_path / 'in.bag'
    if isinstance(content, str):
        (tmp_path / content).write_text('')
    elif isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        with rosbag.Bag(str(path), 'w') as file:
            for topic, msg, time_s in content:
                file.write(topic, msg, genpy.Time.from_sec(time_s))
    line = refused(path, tmp_path / 'out.mp4')
    assert re.match(problem.format(path), line) and '\n' not in line


def test_colors_that_are_refused(bag, tmp_path, refused):
    path = tmp_path / 'colors.yaml'
    path.write_text('blue_hue_min: -7')
    line = refused(bag, tmp_path / 'out.mp4', '--colors', path)
    assert line.startswith('{}: parameter blue_hue_min: got -7, allowed is '.format(path))


@pytest.mark.parametrize('output', ['out.avi', 'out'])
def test_an_output_that_is_no_mp4(bag, make, capsys, output):
    with pytest.raises(SystemExit):
        make(bag, output)
    assert 'expected FILE.mp4' in capsys.readouterr().err


def test_the_bag_itself_is_not_overwritten(bag, tmp_path, refused):
    out, before = tmp_path / 'out.mp4', bag.read_bytes()
    os.link(str(bag), str(out))
    assert refused(bag, out) == (
        'cannot write {}: that is what is filmed; give the film another name'.format(out))
    assert bag.read_bytes() == before and os.path.samefile(str(bag), str(out))


def test_a_path_that_cannot_be_written(bag, refused):
    assert refused(bag, '/nowhere/out.mp4').startswith('cannot write /nowhere/out.mp4')


# a signal arrives when a part of the film is written
INTERRUPTED = """
import signal, sys
from img_recog.replay import film, film_job
add = film.Film.add

def interrupted(self, *image):
    add(self, *image)
    if image[0] > 0.2:
        signal.raise_signal(signal.SIGTERM)

film.Film.add = interrupted
sys.exit(film_job.main(sys.argv[1:]))
"""


def test_a_signal_leaves_no_unfinished_file(bag, tmp_path):
    done = subprocess.run(
        [sys.executable, '-c', INTERRUPTED, str(bag), str(tmp_path / 'out.mp4')],
        stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (128 + signal.SIGTERM, b'')
    assert list(tmp_path.iterdir()) == [bag]
