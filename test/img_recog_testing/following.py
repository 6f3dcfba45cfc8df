"""A robot that drives by its camera, offline, with a check of all contacts."""
import dataclasses
import itertools
import os
from collections import deque

import pybullet

from img_recog import resources
from img_recog.recognition import parameter_file
from img_recog.recognition.settings import with_colors
from img_recog.replay import scenario
from img_recog.replay.chain import SECOND_NS, Chain, Recorder, measure
from img_recog.replay.robot_frames import RobotFrames
from img_recog.simulation.models import Models, State
from img_recog.simulation.settings import SpawnSettings

_CONTACT_STEPS = 4      # of 1 ms: no contact is shorter
FOLLOW = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'config',
                      'follow.yaml')


class Drive(Recorder):
    """The burger in the world color_posts, driven by what it sees.

    results: of all frames; contacts: the names of the bodies other than the floor that it touched.
    """

    def __init__(self, x, y, yaw, posts=None, colors=FOLLOW, size=(160, 120), teleop=False,
                 delays=(0,)):
        """Start at x, y, yaw.

        posts: places (x, y) of posts by name, instead of those of the world. colors: a parameter
        file, '' for the article's colors. delays: how old the processed images are, in periods;
        of one frame after the other, over and over.
        """
        built = scenario.build('color_posts', resources.burger(), SpawnSettings(x, y, 0.0, yaw))
        self.simulator, self.models = built.simulator, Models(built.simulator)
        self._robot = built.simulator.vehicles[0].robot
        self._client = built.simulator.world.physics_client_id
        for name, place in (posts or {}).items():
            self.move(name, *place)
        self.results, self.contacts = [], set()
        self._watch_contacts(built.simulator.world)
        self._built, self._size, self._delays = built, size, itertools.cycle(delays)
        self._settings = parameter_file.read(colors) if colors else with_colors()()
        self._chain = Chain(built.simulator, self._settings, teleop, [self])

    def _watch_contacts(self, world):
        names = {body.body_id: body.name for body in world.bodies}
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

    def run(self, seconds, at_frame=lambda time_s: None):
        """Drive; at_frame is called with the time of each frame, before it is processed."""
        width, height = self._size
        camera = dataclasses.replace(scenario.camera_settings(self._built), camera_width=width,
                                     camera_height=height)
        frames = RobotFrames(self._built, camera, seconds)
        frames.follow(self._chain.simulate_until)
        self._chain.run(measure(self._late(frames, at_frame), self._settings))
        return self

    def _late(self, frames, at_frame):
        images = deque(maxlen=max(next(self._delays) for _ in range(50)) + 1)
        for frame in frames:
            at_frame(frame.stamp_ns / SECOND_NS)
            images.append(frame.image)
            age = min(next(self._delays), len(images) - 1)
            yield frame._replace(image=images[-1 - age])

    def move(self, name, x, y):
        """Move a post to a place, at rest."""
        self.models.set_state(name, State((x, y, 0.15), (0, 0, 0, 1), (0, 0, 0), (0, 0, 0)))

    def gap(self, name):
        """Return the distance between the robot and a body of the world in m."""
        body = next(body for body in self.simulator.world.bodies if body.name == name)
        return min(point[8] for point in pybullet.getClosestPoints(
            self._robot.body_id, body.body_id, 100.0, physicsClientId=self._client))

    def rest_s(self):
        """Return for how long the robot has stood at the end."""
        end = self.results[-1]
        moving = [result.time_ns for result in self.results
                  if abs(result.motion.position - end.motion.position).max() > 0.002
                  or abs(result.motion.yaw - end.motion.yaw) > 0.005]
        return (end.time_ns - max(moving, default=0)) / SECOND_NS
