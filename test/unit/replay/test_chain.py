"""The chain of a replay: when commands are sent in simulated time, and where the robot drives."""
import threading

import pytest

from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay.chain import RECOGNITION, TELEOP, Chain, ColorRecognition, prefetch
from img_recog_helpers import robots
from img_recog_helpers.replaying import BLUE, RED, EventLog, frame
from img_recog_helpers.waiting import wait_for

MS = 10 ** 6
PERIOD = 40 * MS


def replayed(frames, teleop=False, period_ns=PERIOD, **settings):
    """Run frames through a chain in the empty world; return the log and the simulator."""
    log, simulator = EventLog(), robots.assemble()
    recognition = ColorRecognition(with_colors()(**settings))
    chain = Chain(simulator, recognition, teleop, [log])
    chain.end(chain.run(recognition.measure(frames)) + period_ns)
    return log, simulator


def video(*color_lists, start_ns=0, period_ns=PERIOD):
    return [frame(number, start_ns + number * period_ns, *colors)
            for number, colors in enumerate(color_lists)]


def test_areas_centroids_and_commands_of_each_frame():
    log, _ = replayed(video((), (BLUE,), (BLUE, RED), ()))
    assert [result.areas_px for result in log.frames] == [[0, 0], [1600, 0], [1600, 1600], [0, 0]]
    assert log.frames[2].centroids == [(19.5, 19.5), (59.5, 19.5)]
    assert log.frames[3].centroids == [None, None]
    assert [[command.linear_x for command in result.commands] for result in log.frames] == [
        [], [10.0], [10.0, -10.0], []]
    assert log.commands == [(40 * MS, 10.0, RECOGNITION), (80 * MS, 10.0, RECOGNITION),
                            (80 * MS, -10.0, RECOGNITION)]


def test_the_idle_teleop_sends_zeros_at_10_hz_before_the_frame_of_the_same_time():
    log, simulator = replayed(video((BLUE,), (), (), (), (), (BLUE,)), teleop=True)
    assert log.commands == [(0, 0.0, TELEOP), (0, 10.0, RECOGNITION), (100 * MS, 0.0, TELEOP),
                            (200 * MS, 0.0, TELEOP), (200 * MS, 10.0, RECOGNITION)]
    assert simulator.time_s == pytest.approx(0.24)


def test_the_robot_drives_as_the_simulator_does_with_the_same_commands():
    log, simulator = replayed(video((), (BLUE,), (), (RED,), ()))
    same = robots.assemble()
    robot = same.robots[0]
    same.advance(40)
    robot.command(10.0, 0.0)
    same.advance(80)
    robot.command(-10.0, 0.0)
    same.advance(80)
    assert simulator.time_s == same.time_s
    for got, wanted in zip(simulator.robots[0].body.motion(), robot.body.motion()):
        assert tuple(got) == tuple(wanted)
    assert log.frames[3].motion.position[0] > log.frames[0].motion.position[0]


def test_without_the_teleop_a_command_holds():
    short, long = (replayed(video((BLUE,), *[()] * count))[1] for count in (5, 20))
    assert (short.robots[0].body.motion().position[0] + 0.1
            < long.robots[0].body.motion().position[0])


def test_time_starts_at_the_first_stamp():
    start_ns = 1600000000 * 10 ** 9 + 123
    log, simulator = replayed(video((), (BLUE,), start_ns=start_ns), teleop=True)
    assert log.start_ns == start_ns
    assert [result.time_ns for result in log.frames] == [0, PERIOD]
    assert log.commands == [(0, 0.0, TELEOP), (PERIOD, 10.0, RECOGNITION)]
    assert simulator.time_s == pytest.approx(0.08)


def test_a_frame_takes_effect_at_the_nearest_step_without_accumulated_error():
    period_ns = round(10 ** 9 / 29.97)
    log, simulator = replayed(video(*[()] * 300, period_ns=period_ns), period_ns=period_ns)
    assert simulator.time_s == pytest.approx(round(300 * period_ns / MS) / 1000)
    assert log.frames[299].time_ns == 299 * period_ns


def test_lost_colors_stop_the_robot_if_stop_when_lost_is_set():
    frames = video((BLUE,), *[()] * 10)
    log, _ = replayed(frames, stop_when_lost=0.2)
    assert log.commands == [
        (0, 10.0, RECOGNITION), (200 * MS, 0.0, RECOGNITION),
        (440 * MS, 0.0, RECOGNITION)]       # on shutdown


def test_lost_images_stop_it_within_a_tenth_of_a_second():
    frames = [frame(0, 0, BLUE), frame(1, 1000 * MS)]
    log, _ = replayed(frames, stop_when_lost=0.25)
    assert log.commands[:2] == [(0, 10.0, RECOGNITION), (300 * MS, 0.0, RECOGNITION)]


def test_sensors_are_read_at_their_periods():
    log, _ = replayed(video(*[()] * 25))
    times = [reading.time_s for reading in log.readings if reading.sensor == 'odometry']
    assert times == pytest.approx([0.033 * number for number in range(1, 31)])


@pytest.mark.parametrize('count', [0, 1, 3, 4, 5, 1000])
def test_prefetch_gives_the_same_items_in_the_same_order(count):
    assert list(prefetch(range(count), 4)) == list(range(count))


def test_prefetched_items_are_made_ahead_in_another_thread_but_not_more_than_depth():
    made, threads = [], set()

    def items():
        for number in range(100):
            threads.add(threading.current_thread())
            made.append(number)
            yield number

    taken = prefetch(items(), 4)
    assert next(taken) == 0
    wait_for(lambda: len(made) == 5, 'the four that follow')
    assert next(taken) == 1
    wait_for(lambda: len(made) == 6, 'one more')
    taken.close()
    assert len(made) == 6
    assert len(threads) == 1 and threading.current_thread() not in threads


def test_an_exception_of_prefetched_items_is_raised_after_the_items_before_it():
    def items():
        yield 1
        yield 2
        raise ValueError('no more')

    taken = prefetch(items(), 8)
    assert [next(taken), next(taken)] == [1, 2]
    with pytest.raises(ValueError, match='no more'):
        next(taken)
