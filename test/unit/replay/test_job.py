"""The program replay without its process: options, files, summary, and what ends it."""
import csv
import os
import re
import sys
import time

import cv2
import numpy as np
import pytest
import rosbag

from img_recog.camera import calibration
from img_recog.loading import resources
from img_recog.replay import figure, job
from img_recog.replay.plot_data import PlotData
from img_recog.simulation.simulation_settings import SpawnSettings
from img_recog_helpers import expected
from img_recog_helpers.calibrations import KNOWN
from img_recog_helpers.refusals import refusal


class FakeFigure:
    """Keeps what is to be drawn; the picture is a constant."""

    def draw(self, file, title, data):
        self.title, self.data = title, data
        file.write(b'picture')


@pytest.fixture
def run(monkeypatch, capsys, tmp_path, handlers_as_before):
    """A function that runs the program in an empty folder: exit code, output, figure."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        drawn = FakeFigure()
        monkeypatch.setattr(figure, 'draw', drawn.draw)
        monkeypatch.setattr(sys, 'argv', ['replay.py', *map(str, arguments)])
        code = job.main(time.perf_counter() - 1000)
        return code, capsys.readouterr().out, drawn
    return run


def test_options_and_their_defaults():
    defaults = {
        'input': 'a.bag', 'topic': '', 'colors': '', 'output': '', 'teleop': True,
        'world': 'turtlebot3_world', 'urdf': resources.burger(), 'x_pos': -2.0, 'y_pos': -0.5,
        'z_pos': 0.0, 'yaw': 0.0, 'max_image_pixels': 50000000, 'allow_partial_world': False,
        'camera': '', 'seconds': 60.0, 'film': False, 'recognize': '', 'strict': False,
        'calibration': '', 'framerate': 30.0}
    assert vars(job.options_of(['a.bag'])) == defaults
    assert vars(job.options_of(
        'a.bag --topic t --colors c --output o --no-teleop --world w --urdf u --x-pos 1 --y-pos 2 '
        '--z-pos 3 --yaw 0.5 --max-image-pixels 9 --allow-partial-world --film '
        '--framerate 5'.split())) == {
            **defaults, 'topic': 't', 'colors': 'c', 'output': 'o', 'teleop': False, 'world': 'w',
            'urdf': 'u', 'x_pos': 1.0, 'y_pos': 2.0, 'z_pos': 3.0, 'yaw': 0.5,
            'max_image_pixels': 9, 'framerate': 5.0, 'allow_partial_world': True, 'film': True}
    given = job.options_of(['a', '--x-pos', '1', '--yaw', '2'])
    assert job.spawn_settings(given) == SpawnSettings(1.0, -0.5, 0.0, 2.0)


@pytest.mark.parametrize('arguments, words', [
    ([], 'give RECORDING or --camera robot'),
    (['a', '--camera', 'robot'], 'give RECORDING or --camera robot'),
    (['--camera', 'usb'], "argument --camera: invalid choice: 'usb'"),
    (['--camera', 'robot', '--seconds', '0'],
     'argument --seconds: got 0, allowed is more than 0'),
    (['a', '--outp', 'b'], 'unrecognized arguments: --outp'),
    (['a', 'world:=empty'], 'unrecognized arguments: world:=empty'),
    (['a', '--x-pos', 'b'], "argument --x-pos: invalid float value: 'b'"),
    (['a', '--yaw'], 'argument --yaw: expected one argument')])
def test_options_that_are_refused(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        job.options_of(arguments)
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert words in error and 'replay.py: error: ' in error


@pytest.mark.parametrize('name', ['x_pos', 'y_pos', 'z_pos'])
def test_pose_that_is_not_allowed_names_its_option(name):
    option = '--' + name.replace('_', '-')
    assert refusal(job.spawn_settings, job.options_of(['a', option, '1001'])) == (
        option + ': got 1001.0, allowed is a finite number from -1000 to 1000')


def test_world_file_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    (tmp_path / 'home').mkdir()
    for name in ('my.sdf', 'turtlebot3_world', 'home/its.sdf'):
        (tmp_path / name).write_text('')
    assert job.world_name('my.sdf') == str(tmp_path / 'my.sdf')
    assert job.world_name('~/its.sdf') == str(tmp_path / 'home' / 'its.sdf')
    for name in ('turtlebot3_world', 'empty', 'no.sdf', 'home'):
        assert job.world_name(name) == name


def test_a_video_gives_three_files_and_a_summary(run, make_video, tmp_path):
    code, text, drawn = run(make_video(frames=3), '--world', 'empty', '--x-pos', '1.5',
                            '__name:=replay', '--no-teleop')
    assert code == 0
    paths = ['video.replay' + extension for extension in ('.bag', '.csv', '.png')]
    assert sorted(os.listdir(str(tmp_path))) == sorted(paths + ['video.avi'])
    found = re.fullmatch(
        r'3 frames, 0\.240 s simulated in ([\d.]+) s, ([\d.]+) times real time \(([\d.]+) s with '
        r'world and plot\); the robot ends at x 1\.500 m, y -0\.500 m, yaw -?0\.000 rad; wrote ' +
        re.escape(', '.join(paths)) + '\n', text)
    assert found, text
    loop_s, ratio, whole_s = map(float, found.groups())
    assert 1000 < whole_s < 2000 and loop_s < 500
    assert 0.235 / (loop_s + 0.006) < ratio + 0.06 and (ratio - 0.06) * (loop_s - 0.006) < 0.245
    assert drawn.title == 'Replay of video.avi, 3 frames, in the world empty'
    assert isinstance(drawn.data, PlotData) and drawn.data.end_s == pytest.approx(0.24)
    assert (tmp_path / paths[2]).read_bytes() == b'picture'
    with open(paths[1]) as table:
        assert len(table.read().splitlines()) == 4
    with rosbag.Bag(paths[0]) as bag:
        assert bag.get_message_count('/color_detection') == 3
        assert bag.get_message_count('/cmd_vel') == 0
        assert {msg.child_frame_id for _, msg, _ in bag.read_messages('/odom')} == {
            'base_footprint'}


def test_a_folder_of_pictures_is_replayed_at_a_rate(run, tmp_path, caplog):
    (tmp_path / 'pictures').mkdir()
    for number, name in enumerate(('b.png', 'a.jp2', 'c.png')):
        image = np.zeros((64, 64 + 32 * (number == 2), 3), np.uint8)
        assert cv2.imwrite('pictures/' + name, image)
    (tmp_path / 'pictures' / 'notes.txt').write_text('x')
    code, text, _ = run('pictures/', '--world', 'empty', '--framerate', '4')
    assert code == 0 and text.startswith('2 frames, 0.500 s simulated')
    assert caplog.messages == [
        '1 of 4 entries of the folder pictures/ left out: notes.txt',
        '1 of 3 images cannot be used; the first is frame 2: image pictures/c.png is 96x64 in a '
        'folder of 64x64']


def test_a_bag_ends_a_period_after_its_last_image_and_bad_ones_are_warned_of(run, caplog):
    from sensor_msgs.msg import Image
    with rosbag.Bag('some.bag', 'w') as bag:
        for number in range(3):
            msg = Image(height=2, width=2, encoding='bgr8', step=6, data=bytes(12 - number // 2))
            msg.header.stamp.secs = 5 + number
            bag.write('/eye', msg)
    code, text, _ = run('some.bag', '--world', 'empty', '--topic', 'eye')
    assert code == 0 and text.startswith('2 frames, 2.000 s simulated')
    assert [(record.levelname, record.name) for record in caplog.records] == [
        ('WARNING', 'replay.py')]
    assert '1 of 3 images on /eye cannot be used' in caplog.messages[0]
    with rosbag.Bag('some.replay.bag') as bag:
        assert bag.get_message_count('/cmd_vel') == 20


def test_colors_of_a_file(run, make_video, tmp_path, caplog):
    (tmp_path / 'my.yaml').write_text('colors: [green]\n')
    assert run(make_video(), '--colors', 'my.yaml')[0] == 1
    assert 'green_hue_min' in caplog.messages[0]
    (tmp_path / 'my.yaml').write_text('colors: [pink]\npink_hue_min: 1\npink_hue_max: 2\n')
    assert run('video.avi', '--colors', 'my.yaml', '--world', 'empty')[0] == 0
    assert 'pink_px' in (tmp_path / 'video.replay.csv').read_text()


def test_a_function_in_place_of_the_colors(run, make_video, tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(sys, 'path', list(sys.path))
    calibration.save('eye.yaml', KNOWN)
    (tmp_path / 'users_drive.py').write_text(
        'from geometry_msgs.msg import Twist, Vector3\n'
        'def drive(image, stamp, camera_info):\n'
        '    if stamp.to_nsec() == 0:\n        raise ValueError("too early")\n'
        '    return Twist(Vector3(0.5, 0.25, 0.0), Vector3(0.0, 0.0, camera_info.K[0]))\n')
    options = ('--world', 'empty', '--recognize', 'users_drive.py:drive', '--calibration',
               'eye.yaml')
    code, text, drawn = run(make_video(frames=3, size=(128, 96)), *options, '--film')
    assert code == 0 and text.startswith('3 frames, 0.240 s simulated')
    assert caplog.messages == [
        'users_drive.py:drive fails for 1 of 3 frames; the first is frame 0 at 0.000 s: '
        'ValueError: too early (users_drive.py, line 4)']
    with rosbag.Bag('video.replay.bag') as bag:
        assert '/color_detection' not in bag.get_type_and_topic_info().topics
        sent = [msg for _, msg, _ in bag.read_messages('/cmd_vel') if msg.linear.x]
    assert [(msg.linear.y, msg.angular.z) for msg in sent] == [
        (0.25, pytest.approx(KNOWN.camera_matrix[0] * 128 / 640))] * 2
    with open('video.replay.csv') as table:
        rows = list(csv.DictReader(table))
    assert [row['commands_linear_x_m_per_s'] for row in rows] == ['', '0.5', '0.5']
    assert not any(name.endswith('_px') for name in rows[0])
    assert len(drawn.data.colors) == 0 and drawn.data.commands[:, 1].tolist() == [0.5, 0.5]
    assert cv2.VideoCapture('video.replay.mp4').isOpened()
    assert run('video.avi', *options, '--strict')[0] == 1
    assert caplog.messages[-1].startswith('users_drive.py:drive fails for frame 0 at 0.000 s: ')


def test_options_that_make_no_sense(run, make_video, tmp_path, caplog):
    make_video()

    def line(arguments):
        caplog.clear()
        assert run(*arguments.split())[:2] == (1, '')
        assert os.listdir(str(tmp_path)) == ['video.avi']
        return '\n'.join(caplog.messages)
    expected.check_cases('refused/replays.txt', line)
