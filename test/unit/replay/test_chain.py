"""Frames to commands to a robot, in simulated time: when what is sent, and where it drives."""
import pytest

from img_recog.recognition.settings import with_colors
from img_recog.replay.chain import RECOGNITION, TELEOP, Chain, measured
from img_recog_testing import robots
from img_recog_testing.replaying import BLUE, RED, Notebook, frame

MS = 10 ** 6
PERIOD = 40 * MS


def replayed(frames, teleop=False, period_ns=PERIOD, **settings):
    """Run frames through a chain in the empty world; return notebook and simulator."""
    notebook, simulator = Notebook(), robots.simulator()
    recognition = with_colors()(**settings)
    chain = Chain(simulator, recognition, teleop, [notebook])
    chain.end(chain.run(measured(frames, recognition)) + period_ns)
    return notebook, simulator


def video(*seen, start_ns=0, period_ns=PERIOD):
    return [frame(number, start_ns + number * period_ns, *colors)
            for number, colors in enumerate(seen)]


def test_areas_centroids_and_commands_of_each_frame():
    notebook, _ = replayed(video((), (BLUE,), (BLUE, RED), ()))
    assert [seen.areas_px for seen in notebook.frames] == [[0, 0], [1600, 0], [1600, 1600], [0, 0]]
    assert notebook.frames[2].centroids == [(19.5, 19.5), (59.5, 19.5)]
    assert notebook.frames[3].centroids == [None, None]
    assert [[command.linear_x for command in seen.commands] for seen in notebook.frames] == [
        [], [10.0], [10.0, -10.0], []]
    assert notebook.commands == [(40 * MS, 10.0, RECOGNITION), (80 * MS, 10.0, RECOGNITION),
                                 (80 * MS, -10.0, RECOGNITION)]


def test_the_idle_teleop_sends_zeros_at_10_hz_before_the_frame_of_the_same_time():
    notebook, simulator = replayed(video((BLUE,), (), (), (), (), (BLUE,)), teleop=True)
    assert notebook.commands == [(0, 0.0, TELEOP), (0, 10.0, RECOGNITION), (100 * MS, 0.0, TELEOP),
                                 (200 * MS, 0.0, TELEOP), (200 * MS, 10.0, RECOGNITION)]
    assert simulator.time_s == pytest.approx(0.24)


def test_the_robot_drives_as_the_simulator_does_with_the_same_commands():
    notebook, simulator = replayed(video((), (BLUE,), (), (RED,), ()))
    same = robots.simulator()
    vehicle = same.vehicles[0]
    same.advance(40)
    vehicle.command(10.0, 0.0)
    same.advance(80)
    vehicle.command(-10.0, 0.0)
    same.advance(80)
    assert simulator.time_s == same.time_s
    for got, wanted in zip(simulator.vehicles[0].robot.motion(), vehicle.robot.motion()):
        assert tuple(got) == tuple(wanted)
    assert notebook.frames[3].motion.position[0] > notebook.frames[0].motion.position[0]


def test_without_the_teleop_a_command_holds():
    short, long = (replayed(video((BLUE,), *[()] * count))[1] for count in (5, 20))
    assert (short.vehicles[0].robot.motion().position[0] + 0.1
            < long.vehicles[0].robot.motion().position[0])


def test_time_is_counted_from_the_first_stamp():
    start_ns = 1600000000 * 10 ** 9 + 123
    notebook, simulator = replayed(video((), (BLUE,), start_ns=start_ns), teleop=True)
    assert notebook.start_ns == start_ns
    assert [seen.time_ns for seen in notebook.frames] == [0, PERIOD]
    assert notebook.commands == [(0, 0.0, TELEOP), (PERIOD, 10.0, RECOGNITION)]
    assert simulator.time_s == pytest.approx(0.08)


def test_a_frame_between_two_steps_is_at_the_nearest_and_nothing_adds_up():
    period_ns = round(10 ** 9 / 29.97)
    notebook, simulator = replayed(video(*[()] * 300, period_ns=period_ns), period_ns=period_ns)
    assert simulator.time_s == pytest.approx(round(300 * period_ns / MS) / 1000)
    assert notebook.frames[299].time_ns == 299 * period_ns


def test_lost_colors_stop_the_robot_when_the_settings_say_so():
    frames = video((BLUE,), *[()] * 10)
    notebook, _ = replayed(frames, stop_when_lost=0.2)
    assert notebook.commands == [
        (0, 10.0, RECOGNITION), (200 * MS, 0.0, RECOGNITION),
        (440 * MS, 0.0, RECOGNITION)]       # and at the end


def test_lost_images_too_within_a_tenth_of_a_second():
    frames = [frame(0, 0, BLUE), frame(1, 1000 * MS)]
    notebook, _ = replayed(frames, stop_when_lost=0.25)
    assert notebook.commands[:2] == [(0, 10.0, RECOGNITION), (300 * MS, 0.0, RECOGNITION)]


def test_the_sensors_are_read_at_their_own_times():
    notebook, _ = replayed(video(*[()] * 25))
    times = [reading.time_s for reading in notebook.readings if reading.sensor == 'odometry']
    assert times == pytest.approx([0.033 * number for number in range(1, 31)])
