"""The colors of config/follow.yaml, on a camera of the simulated robot.

Offline: the same recognition, commands and simulation as in the demo, and as in replay.py.
"""
import dataclasses
import itertools
import math
import os
from collections import deque

import pybullet
import pytest

from img_recog.loading import resources
from img_recog.recognition import parameter_file
from img_recog.recognition.commands import STOP
from img_recog.replay import scenario
from img_recog.replay.chain import SECOND_NS, Chain, ColorRecognition, Recorder
from img_recog.replay.robot_frames import RobotFrames
from img_recog.simulation.models import Models, State
from img_recog.simulation.simulation_settings import SpawnSettings
from img_recog_helpers.pages import ROOT

_CONTACT_STEPS = 4      # of 1 ms: no contact is shorter
FOLLOW = os.path.join(ROOT, 'config', 'follow.yaml')
BLUE = ('blue_post_1', 'blue_post_2')
POSTS = {'blue_post_1': (0.5, -0.15), 'blue_post_2': (1.5, 2.5), 'red_post_1': (-3.4, -0.5),
         'red_post_2': (2.5, -3.4)}
JITTER = (0, 2, 1, 0, 0, 2, 2, 1)


class Drive(Recorder):
    """The burger in the world color_posts, driven by what it sees.

    results: of all frames; contacts: the names of the bodies other than the floor that it touched.
    """

    def __init__(self, x, y, yaw, posts=None, colors=FOLLOW, delays=(0,), lag_ns=0):
        """Start at x, y, yaw.

        posts: places (x, y) of posts by name, instead of those of the world. colors: a parameter
        file. delays: how old the processed images are, in periods;
        of one frame after the other, over and over. lag_ns: how much later than a command of an
        image the next one of it comes, as those of a node do.
        """
        built = scenario.build('color_posts', resources.burger(), SpawnSettings(x, y, 0.0, yaw))
        self.simulator, self.models = built, Models(built)
        self._robot = built.robots[0].body
        self._client = built.world.physics_client_id
        for name, place in (posts or {}).items():
            self.move(name, *place)
        self.results, self.contacts = [], set()
        self._watch_contacts(built.world)
        self._built, self._delays = built, itertools.cycle(delays)
        self._lag_ns, self._lagged_ns = lag_ns, 0
        self._recognition = ColorRecognition(parameter_file.read(colors))
        self._chain = Chain(built, self._recognition, False, [self])

    def _watch_contacts(self, world):
        names = {body.body_id: body.name for body in world.scenery}
        advance = world.step

        def step(count=1):
            for done in range(0, count, _CONTACT_STEPS):
                advance(min(_CONTACT_STEPS, count - done))
                for contact in pybullet.getContactPoints(self._robot.body_id,
                                                         physicsClientId=self._client):
                    if contact[2] in names and contact[8] <= 0:
                        self.contacts.add(names[contact[2]])
        world.step = step

    def on_frame(self, result):
        self.results.append(result)
        self._lagged_ns = result.time_ns

    def on_command(self, sent):
        self._lagged_ns += self._lag_ns
        self._chain.simulate_until(self._lagged_ns)

    def run(self, seconds, at_frame=lambda time_s: None, until=lambda drive: False):
        """Drive; at_frame is called with the time of each frame, before it is processed.

        seconds: at most; until: until(drive) says after a frame that the rest is not needed.
        """
        camera = dataclasses.replace(scenario.camera_settings(self._built), camera_width=160,
                                     camera_height=120)
        frames = RobotFrames(self._built, camera, seconds)
        frames.follow(self._chain.simulate_until)
        self._chain.run(self._recognition.measure(self._late(frames, at_frame, until)))
        return self

    def _late(self, frames, at_frame, until):
        images = deque(maxlen=max(next(self._delays) for _ in range(50)) + 1)
        for frame in frames:
            if until(self):
                break
            at_frame(frame.stamp_ns / SECOND_NS)
            images.append(frame.image)
            age = min(next(self._delays), len(images) - 1)
            yield frame._replace(image=images[-1 - age])

    def move(self, name, x, y):
        """Move a post to a place, at rest."""
        self.models.set_state(name, State((x, y, 0.15), (0, 0, 0, 1), (0, 0, 0), (0, 0, 0)))

    def gap(self, name):
        """Return the distance between the robot and a body of the world in m."""
        body = next(body for body in self.simulator.world.scenery if body.name == name)
        return min(point[8] for point in pybullet.getClosestPoints(
            self._robot.body_id, body.body_id, 100.0, physicsClientId=self._client))

    def rest_s(self):
        """Return for how long the robot has stood at the end."""
        end = self.results[-1]
        moving_ns = next((result.time_ns for result in reversed(self.results)
                          if abs(result.motion.position - end.motion.position).max() > 0.002
                          or abs(result.motion.yaw - end.motion.yaw) > 0.005), 0)
        return (end.time_ns - moving_ns) / SECOND_NS

    def rests(self):
        """Return whether the robot has stood for longer than a test of its rest asks for."""
        return self.results and self.rest_s() > 1.2


def assert_stands_before(drive, name, nearest=0.4, farthest=0.55, posts=None):
    """Check that the robot has come to rest before a post and has touched nothing."""
    assert drive.contacts == set()
    assert drive.rest_s() > 1.0 and drive.results[-1].commands[-1] == STOP
    assert nearest < drive.gap(name) < farthest
    for name, place in {**POSTS, **(posts or {})}.items():
        assert drive.models.state(name).position[:2] == pytest.approx(place, abs=0.002), name


@pytest.mark.parametrize('x, y, yaw, delays, name', [
    (-1.0, -1.2, -0.6, (1,), 'blue_post_1'), (1.2, 0.9, 1.9, (2,), 'blue_post_2'),
    # beside a wall, and beside a red post
    (2.8, 3.8, 3.0, JITTER, 'blue_post_2'), (-1.0, 0.1, -2.6, JITTER, 'blue_post_1')])
def test_the_robot_finds_a_blue_post_and_stops_before_it(x, y, yaw, delays, name):
    posts = {'red_post_1': (-1.3, 0.1)}
    drive = Drive(x, y, yaw, posts, delays=delays).run(14.0, until=Drive.rests)
    assert_stands_before(drive, name, posts=posts)


@pytest.mark.parametrize('distance, bearing, seconds', [
    (0.22, 0.0, 4.0), (0.24, 1.2, 5.0), (0.35, -0.5, 5.0)])
def test_a_post_that_is_near_at_the_start_is_not_touched(distance, bearing, seconds):
    posts = {'blue_post_1': (distance * math.cos(bearing), distance * math.sin(bearing))}
    drive = Drive(0.0, 0.0, 0.0, posts, delays=JITTER)
    begin = drive.gap('blue_post_1')
    drive.run(seconds, until=Drive.rests)
    assert_stands_before(drive, 'blue_post_1', begin - 0.01, begin + 0.06, posts)


@pytest.mark.parametrize('aside', [0.0, 0.12])
def test_a_red_post_in_the_way_is_not_touched(aside):
    posts = {'red_post_1': (-0.8, aside), 'blue_post_1': (0.5, 0.0)}
    drive = Drive(-1.6, 0.0, 0.0, posts, delays=JITTER).run(9.0)
    assert drive.contacts == set()
    assert drive.models.state('red_post_1').position[:2] == pytest.approx((-0.8, aside), abs=0.002)


def test_the_robot_follows_a_post_that_is_moved():
    x, y = 0.0, -0.5

    def place(time_s):
        """Away for 6 s at 0.15 m/s, a pause, and aside."""
        return (x + 0.15 * min(max(time_s - 4.0, 0.0), 6.0),
                y + 0.15 * min(max(time_s - 13.0, 0.0), 4.0))
    drive = Drive(-1.0, -0.5, 0.0, {'blue_post_1': (x, y)}, delays=JITTER)
    gaps = {}

    def at_frame(time_s):
        drive.move('blue_post_1', *place(time_s))
        gaps[time_s] = drive.gap('blue_post_1')
    drive.run(22.0, at_frame)
    assert_stands_before(drive, 'blue_post_1', posts={'blue_post_1': place(22.0)})
    before, between = (min((gap for time_s, gap in gaps.items() if abs(time_s - at_s) < 0.02))
                       for at_s in (4.0, 12.5))
    assert 0.4 < before < 0.55 and 0.4 < between < 0.55
    assert min(gaps.values()) > 0.4 and drive.results[-1].motion.position[0] > 0.2
    ahead = drive.results[-1].motion
    x, y = place(22.0)
    bearing = math.atan2(y - ahead.position[1], x - ahead.position[0]) - ahead.yaw
    assert abs(bearing) < 0.2


def test_before_the_post_the_robot_stands_although_the_commands_come_one_by_one():
    drive = Drive(-0.3, -0.15, 0.0, lag_ns=4 * SECOND_NS // 1000).run(12.0)
    assert_stands_before(drive, 'blue_post_1')
    headings = [result.motion.yaw for result in drive.results if result.time_ns > 6 * SECOND_NS]
    assert math.degrees(max(headings) - min(headings)) < 1.0
    assert all(len(result.commands) == 1 for result in drive.results)


def test_without_the_near_colors_the_post_is_touched(tmp_path):
    """The contacts are really found."""
    with open(FOLLOW) as file:
        text = file.read()
    path = tmp_path / 'no_stop.yaml'
    path.write_text(text.replace('near_row_min: 0.85', 'near_row_min: 1.0').replace(
        'left_row_min: 0.85', 'left_row_min: 1.0').replace(
        'right_row_min: 0.85', 'right_row_min: 1.0'))
    drive = Drive(-0.3, -0.15, 0.0, colors=str(path)).run(
        6.0, until=lambda drive: drive.contacts)
    assert drive.contacts == {'blue_post_1'}
