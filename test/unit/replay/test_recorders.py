"""The bag, the table and the picture of a replay: contents, and the same bytes every time."""
import csv
import functools
import io
import math
import tracemalloc

import numpy as np
import pytest
import rosbag

from img_recog.command_line import results
from img_recog.conversions import color_detection_msgs, robot_msgs, twist_msgs
from img_recog.recognition.commands import Command
from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay import figure, plot_data
from img_recog.replay.chain import Chain, ColorRecognition, CommandSent, FrameResult
from img_recog.replay.recorders import BagRecorder, PlotRecorder, TableRecorder
from img_recog.simulation.physics.body import Motion
from img_recog.simulation.pictures.footprints import footprints
from img_recog_helpers import robots
from img_recog_helpers.replaying import BLUE, RED, EventLog, frame

START_NS = 1600000000 * 10 ** 9 + 123
PERIOD_NS = 40 * 10 ** 6
PICTURE = ((), (BLUE,), (BLUE, RED), ()) * 3


class BagFile(io.BytesIO):
    """A bag in memory, whose bytes are kept when it is closed."""

    mode = 'w+b'        # rosbag asks

    def close(self):
        self.value = self.getvalue()


@functools.lru_cache(maxsize=None)
def replayed(start_ns=0, seen=PICTURE, **odometry):
    """Return bag and table as bytes, what a picture shows, and a log."""
    settings, log = with_colors()(), EventLog()
    bag_file, csv_file = BagFile(), io.BytesIO()
    plot = PlotRecorder(settings.colors)
    simulator = robots.assemble('turtlebot3_world', -2.0, -0.5,
                                odometry=robots.burgers('odometry', **odometry))
    bag = BagRecorder(bag_file, settings.color_names, simulator.robots[0].settings.sensors)
    recognition = ColorRecognition(settings)
    frames = (frame(number, start_ns + number * PERIOD_NS, *colors)
              for number, colors in enumerate(seen))
    with results.csv_table(csv_file, TableRecorder.head(settings.color_names)) as rows:
        chain = Chain(simulator, recognition, True, [log, bag, TableRecorder(rows), plot])
        chain.end(PERIOD_NS + chain.run(recognition.measure(frames)))
    bag.close()
    shown = plot.data(len(seen) * 0.04, footprints(simulator.world))
    return bag_file.value, csv_file.getvalue().decode(), shown, log


def drawn(bag, table, shown):
    """Return bag, table and picture as bytes."""
    file = io.BytesIO()
    figure.draw(file, 'a test', shown)
    return bag, table, file.getvalue()


def messages(data):
    """Return a list of (stamp of recording in ns, message) for each topic."""
    found = {}
    for topic, msg, time in rosbag.Bag(BagFile(data)).read_messages():
        found.setdefault(topic, []).append((time.to_nsec(), msg))
    return found


def test_the_same_input_gives_the_same_bytes():
    first, second = (drawn(*each[:3]) for each in (replayed(), replayed.__wrapped__()))
    assert first == second
    assert replayed(seen=PICTURE[1:])[:2] != first[:2]


def test_bag():
    data, _, _, log = replayed(START_NS)
    found = messages(data)
    assert sorted(found) == ['/cmd_vel', '/color_detection', '/joint_states', '/odom', '/tf']
    assert [(stamp - START_NS, *twist_msgs.from_msg(msg)) for stamp, msg in found['/cmd_vel']] == [
        (time_ns, linear_x, 0.0, 0.0) for time_ns, linear_x, _ in log.commands]
    assert len(found['/color_detection']) == len(log.frames) == len(PICTURE)
    for (stamp, msg), seen in zip(found['/color_detection'], log.frames):
        assert stamp == seen.frame.stamp_ns == msg.header.stamp.to_nsec()
        assert msg.header.frame_id == 'head_camera'
        assert color_detection_msgs.from_msg(msg) == (['blue', 'red'], seen.areas_px,
                                                      seen.centroids)
    motions = [reading for reading in log.readings if reading.sensor == 'odometry']
    assert len(motions) == len(found['/odom']) == len(found['/tf']) == 14
    for (stamp, msg), (_, tf), reading in zip(found['/odom'], found['/tf'], motions):
        assert stamp == msg.header.stamp.to_nsec() == START_NS + round(reading.time_s * 1e9)
        assert (msg.header.frame_id, msg.child_frame_id) == ('odom', 'base_footprint')
        for got, wanted in zip(robot_msgs.odometry_from_msg(msg), reading.value):
            assert tuple(got) == tuple(wanted)
        # rosbag makes a separate class for each topic
        assert str(tf.transforms[0].header) == str(msg.header)
        assert str(tf.transforms[0].transform.rotation) == str(msg.pose.pose.orientation)
    assert found['/joint_states'][0][1].name == ['wheel_right_joint', 'wheel_left_joint']


def test_bag_has_no_message_at_time_zero():
    found = messages(replayed()[0])
    assert min(stamp for entries in found.values() for stamp, _ in entries) == 1
    assert found['/color_detection'][0][1].header.stamp.to_nsec() == 0


def test_bag_of_several_chunks_is_complete():
    file = BagFile()
    bag = BagRecorder(file, ['blue'], {})
    bag.start(START_NS)
    for number in range(10000):
        bag.on_command(CommandSent(number, Command(float(number)), 'somebody'))
    bag.close()
    assert file.value.count(b'\x04\0\0\0op=\x05') > 1
    assert [(stamp - START_NS, msg.linear.x) for stamp, msg in messages(file.value)['/cmd_vel']
            ] == [(number, number) for number in range(10000)]


def test_bag_without_tf_when_the_robot_says_so():
    assert '/tf' not in messages(replayed(publish_odom_tf=False)[0])


def test_table():
    _, text, _, log = replayed(START_NS)
    assert text.splitlines()[0] == (
        'time_s,frame,stamp_s,blue_px,red_px,commands_linear_x_m_per_s,'
        'commands_angular_z_rad_per_s,x_m,y_m,yaw_rad,linear_x_m_per_s,angular_z_rad_per_s')
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == len(PICTURE)
    assert rows[1]['time_s'] == '0.040000000' and rows[1]['stamp_s'] == '1600000000.040000123'
    assert [row['commands_linear_x_m_per_s'] for row in rows[:4]] == ['', '10.0', '10.0 -10.0', '']
    assert rows[2]['commands_angular_z_rad_per_s'] == '0.0 0.0'
    for number, (row, seen) in enumerate(zip(rows, log.frames)):
        assert int(row['frame']) == number
        assert [int(row['blue_px']), int(row['red_px'])] == seen.areas_px
        assert float(row['x_m']) == pytest.approx(seen.motion.position[0], abs=5e-7)
        assert float(row['linear_x_m_per_s']) == pytest.approx(seen.motion.linear[0], abs=5e-7)
    assert '-0.000000' not in text


def test_data_of_the_picture_are_pose_velocities_and_areas():
    plot = PlotRecorder(with_colors()().colors)
    turned = (0.0, 0.0, math.sin(0.4), math.cos(0.4))
    motion = Motion(np.array((1.0, 2.0, 3.0)), turned, np.array((4.0, 5.0, 6.0)),
                    np.array((7.0, 8.0, 9.0)))
    plot.on_frame(FrameResult(frame(0, 0), 5 * 10 ** 8, [10, 11], [None, None], [], motion))
    data = plot.data(1.0, [])
    assert plot.frames == 1
    assert data.motion.tolist() == [[0.5, 1.0, 2.0, pytest.approx(0.8), 4.0, 9.0]]
    assert data.areas.tolist() == [[0.5, 10.0, 11.0]]


STILL = Motion(np.zeros(3), (0.0, 0.0, 0.0, 1.0), np.zeros(3), np.zeros(3))


def record(recorder, numbers):
    """Have a recorder note a frame and a command for each number."""
    seen = frame(0, 0)
    for number in numbers:
        time_ns = number * PERIOD_NS
        moved = STILL._replace(position=np.array((number, -number, 0.0)))
        recorder.on_frame(FrameResult(seen, time_ns, [number % 1000, 0], [None, None], [], moved))
        recorder.on_command(CommandSent(time_ns, Command(number % 2, 0.0), 'teleop'))


@pytest.mark.parametrize('make', [
    lambda path: BagRecorder(open(path, 'wb+'), ['blue', 'red'], {}),
    lambda path: PlotRecorder(with_colors()().colors)])
def test_memory_does_not_grow_with_the_number_of_frames(tmp_path, make):
    recorder, count = make(str(tmp_path / 'a.bag')), plot_data.MAX_ROWS
    record(recorder, range(count))
    tracemalloc.start()
    record(recorder, range(count, 3 * count))
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert grown < 2000000      # 60 bytes a frame, and the chunk that is written


def test_a_long_drive_keeps_its_extremes_and_its_path(monkeypatch):
    monkeypatch.setattr(plot_data, 'MAX_ROWS', 64)
    plot = PlotRecorder(with_colors()().colors)
    record(plot, range(5000))
    data = plot.data(200.0, [])
    for rows in (data.motion, data.areas, data.idle):
        assert 32 <= len(rows) <= 64 + 5000 / 16
        assert rows[0, 0] == 0.0 and rows[-1, 0] == 4999 * 0.04 and (np.diff(rows[:, 0]) > 0).all()
        assert np.diff(rows[:, 0]).max() < 200 / 16
    assert (data.motion[:, 1] == -data.motion[:, 2]).all()      # on its path
    assert data.areas[:, 1].min() == 0 and data.areas[:, 1].max() == 999
    assert set(data.idle[:, 1]) == {0.0, 1.0} and plot.frames == 5000


def test_a_number_that_is_rounded_to_zero_has_no_sign():
    file = io.StringIO()
    motion = Motion(np.full(3, -4e-7), (0.0, 0.0, 0.0, 1.0), np.zeros(3), np.full(3, -6e-7))
    TableRecorder(csv.writer(file)).on_frame(FrameResult(frame(0, 0), 0, [], [], [], motion))
    row, = csv.DictReader(io.StringIO(file.getvalue()), TableRecorder.head([]))
    assert (row['x_m'], row['angular_z_rad_per_s']) == ('0.000000', '-0.000001')
