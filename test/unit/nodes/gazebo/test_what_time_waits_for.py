"""Whether simulated time passes in the simulator's loop, while it waits for others.

The physics, images, lockstep and loop are real; other processes, other nodes and the wall clock
are not.
"""
from types import SimpleNamespace

import pytest
import rospy
from geometry_msgs.msg import Twist

from img_recog.nodes.gazebo import images, lockstep
from img_recog.nodes.gazebo.gazebo_node import Gazebo
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep, LockstepSettings
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate
from img_recog.simulation.pacing import Pace
from img_recog.simulation.simulation_settings import CameraSettings, ViewSettings
from img_recog_helpers import expected, robots

CAMERA = CameraSettings(camera_frame='base_link', camera_width=32, camera_height=24,
                        camera_rate=50.0, camera_optical_frame='lens',
                        camera_image_topic='eye/image', camera_info_topic='eye/info')
STEPS, TIMEOUT_S = 40, 5.0      # two images


class FakeProcess:
    """Draws when the test says so."""

    def __init__(self, *_):
        self.is_ready = self.is_busy = self.has_failed = False
        self.request = self.lost = None

    @property
    def is_loading(self):
        return not (self.is_ready or self.has_failed)

    @property
    def has_lost(self):
        return self.lost is not None

    def draw(self, shots, poses, publish):
        self.request = publish

    def draw_again(self):
        self.request, self.lost = self.lost, None

    def start(self):
        """Start to load."""

    set_cameras = set_scene = close = lambda self, *_: None


class FakeSubscriber:
    """Takes the answers of the test."""

    made = {}

    def __init__(self, name, data_class, callback, buff_size=0):
        self.type, self.receive = data_class._type, callback
        self.made[name] = self

    def publishers(self):
        return {'/node'}

    def is_settled(self):
        return True

    def unregister(self):
        """End."""


class FakeConnections:
    """Are there when the test says so."""

    found, uris = (), {}

    def __init__(self, *_):
        """Take what Connections takes."""

    def missing(self, topics):
        return list(self.found)

    def own(self):
        return set()

    def shared(self):
        return []


class Rig:
    """A loop with a camera and a scanner; each method is an event."""

    def __init__(self, monkeypatch, publishers, clock, kinds):
        self.clock, self.publishers = clock, publishers
        FakeConnections.found = ('a publisher of /cmd_vel',)
        self.simulator = robots.assemble(cameras=[CAMERA])
        self.answered = []
        pace, calls = Pace(0.0), ServiceCalls()
        self.gate = TimeGate(Mode.RUNNING, calls.wake, TIMEOUT_S if kinds else None)
        answers = Lockstep(LockstepSettings('r/cmd_vel', kinds, TIMEOUT_S) if kinds
                           else LockstepSettings(), self.gate, self.simulator)
        self.process = FakeProcess()
        monkeypatch.setattr(images, 'ImageProcess', lambda *_: self.process)
        drawn = Images(self.simulator, ViewSettings(), SimpleNamespace(set=lambda *_: None),
                       self.gate, calls.wake, answers.redelivery)
        topics = SimpleNamespace(namespaces=lambda *_: ['r'], publish=lambda *_: None, **{
            name: lambda: None for name in ('apply_commands', 'disable_unused',
                                            'discard_commands')})
        mounted, = self.simulator.robots[0].sensors
        drawn.add_cameras(mounted)
        answers.subscribe_commands('r/cmd_vel', Twist, lambda _: None)
        answers.subscribe()
        publishers['eye/image'].subscribers = 1
        loop = self.loop = Gazebo.__new__(Gazebo)
        vars(loop).update(
            _simulator=self.simulator, _pace=pace, _calls=calls, _lockstep=answers,
            _images=drawn, _topics=topics, _services=None, _clock_steps=10, _free_run_periods=2,
            _gate=self.gate,
            _clock=SimpleNamespace(count=lambda _: None, add=lambda: None, flush=lambda: None,
                                   periods=SimpleNamespace(add=lambda _: None)))
        calls.process = lambda _: None

    def turn(self):
        """Run the loop once; return what it did."""
        before = self.simulator.steps
        self.loop._run_once()
        if self.answered:
            return 'is answered at {:g} s'.format(self.answered.pop())
        steps = self.simulator.steps - before
        return 'passes, {} ms'.format(steps) if steps else 'waits'

    def loop_again(self):
        """Only another turn of the loop."""

    def load(self):
        self.process.is_ready = True

    def draw(self):
        publish, self.process.request = self.process.request, None
        publish([('image', None)])

    def kill(self):
        self.process.is_ready = False
        self.process.request, self.process.lost = None, self.process.request

    def fail(self):
        self.process.is_ready, self.process.has_failed = False, True
        self.process.request = None

    def answer(self):
        FakeSubscriber.made['/r/cmd_vel'].receive(Twist(), {'callerid': '/node'})

    def wait(self):
        self.clock.advance(TIMEOUT_S)

    def subscribe(self):
        self.publishers['eye/image'].subscribers = 1

    def unsubscribe(self):
        self.publishers['eye/image'].subscribers = 0

    def connect(self):
        FakeConnections.found = ()

    def pause(self):
        self.gate.change('pause')

    def unpause(self):
        self.gate.change('unpause')

    def step(self):
        self.gate.step(self.simulator.steps + STEPS,
                       lambda: self.answered.append(self.simulator.time_s))

    def reset(self):
        self.loop._reset_simulation()

    def reset_world(self):
        self.loop._reset(self.simulator.reset_world)

    def remove_robot(self):
        self.loop._lockstep.forget('r')


@pytest.fixture
def make(monkeypatch, publishers, clock):
    monkeypatch.setattr(lockstep, 'Connections', FakeConnections)
    monkeypatch.setattr(lockstep, 'SettledSubscriber', FakeSubscriber)
    monkeypatch.setattr(lockstep.time, 'monotonic', clock)
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: True)
    monkeypatch.setattr(rospy, 'Subscriber', lambda *_, **__: None)
    monkeypatch.setattr(rospy, 'get_rostime', rospy.Time)
    for log in ('logwarn', 'loginfo'):
        monkeypatch.setattr(rospy, log, lambda *_: None)
    return lambda kinds: Rig(monkeypatch, publishers, clock, kinds)


def test_timelines_of_the_loop(make):
    def run(text):
        kinds, *events = text.split()
        rig = make('' if kinds == 'free:' else kinds[:-1])
        lines = []
        for event in events:
            getattr(rig, event)()
            lines.append('{:12} {}'.format(event, rig.turn()))
        return '\n'.join(lines)
    expected.check_cases('timelines/time.txt', run)
