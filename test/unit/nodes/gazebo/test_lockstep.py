"""Which messages are answers, by subscribers and a master of the test."""
import io

import pytest
import rospy
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from img_recog.errors import UserError
from img_recog.nodes.gazebo import lockstep
from img_recog.nodes.gazebo.lockstep import Lockstep, LockstepSettings
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate
from img_recog.settings import SettingError
from img_recog.simulation.simulated_model import Reading
from img_recog.simulation.sensors.robot_camera import CAMERA


class FakeSubscriber:
    made = {}

    def __init__(self, name, data_class, callback, buff_size=0):
        self.type, self.callback, self.nodes = data_class._type, callback, {'/node'}
        self.made[name] = self

    def send(self, msg, node='/node'):
        self.nodes.add(node)
        header = {'callerid': node, 'type': msg._type, 'message_definition': msg._full_text}
        if self.type == '*':
            buffer = io.BytesIO()
            msg.serialize(buffer)
            msg = rospy.AnyMsg().deserialize(buffer.getvalue())
        self.callback(msg, header)

    def publishers(self):
        return self.nodes

    def is_settled(self):
        return True

    def unregister(self):
        self.nodes = None


@pytest.fixture
def rig(monkeypatch):
    """What makes a Lockstep; what it logs, and the time of the wall and of the simulation."""
    class Rig:
        said, wall_s, now_s, missing, woken = [], 1000.0, 0.0, [], 0
        time_s = property(lambda self: self.now_s)      # of the simulator

        def make(self, topics, **settings):
            def wake():
                self.woken += 1
            settings = LockstepSettings(topics, **settings)
            self.gate = TimeGate(Mode.RUNNING, wake, settings.lockstep_timeout)
            made = Lockstep(settings, self.gate, self)
            self.commands = []
            made.subscribe_commands('cmd_vel', Twist, self.commands.append)
            made.subscribe()
            self.send = {name: each.send for name, each in FakeSubscriber.made.items()}
            return made

        def expect(self, made, time_s, namespaces=('',), everyone=('',)):
            self.now_s = time_s
            made.expect([Reading('', 'camera', CAMERA, time_s, None)],
                        lambda names=None: everyone if names is None else namespaces)
            self.gate.notify_sent()
            return self.waits(made)

        def waits(self, made):
            is_answered = made.look()
            self.gate.report(self.now_s)
            return not is_answered

    found = Rig()
    monkeypatch.setattr(FakeSubscriber, 'made', {})
    monkeypatch.setattr(lockstep, 'SettledSubscriber', FakeSubscriber)
    monkeypatch.setattr(lockstep, 'Connections', lambda *_: found)

    def missing(topics):
        found.asked = topics
        return found.unconnected
    found.missing = missing
    found.shared, found.unconnected, found.others = lambda: found.others, [], []
    found.own, found.uris = lambda: {'/odom', '/scan'}, {'/node': 'http://a:1'}
    monkeypatch.setattr(lockstep.time, 'monotonic', lambda: found.wall_s)
    monkeypatch.setattr(rospy, 'get_rostime', lambda: rospy.Time.from_sec(found.now_s))
    for log in ('logwarn', 'loginfo'):
        monkeypatch.setattr(rospy, log, lambda text, *values: found.said.append(text % values))
    monkeypatch.setattr(lockstep.ThrottledWarning.__init__, '__defaults__',
                        (lambda: found.wall_s, lambda text, *values: found.said.append(
                            text % values)))
    found.said = []
    return found


def test_a_message_without_a_header_answers_what_was_sent_before(rig):
    made = rig.make('cmd_vel')
    assert not rig.waits(made)
    made.expect([Reading('', 'camera', CAMERA, 0.1, None)], lambda *_: [''])
    rig.send['/cmd_vel'](Twist())       # while the image is drawn
    assert rig.woken == 0
    assert rig.waits(made)
    rig.send['/cmd_vel'](Twist())
    assert not rig.waits(made) and rig.woken == 1 and len(rig.commands) == 2
    assert len(rig.said) == 1 and '/node publishes more than one message' in rig.said[0]


def test_a_node_that_replaces_another_one(rig):
    made = rig.make('cmd_vel')
    rig.expect(made, 0.1)
    rig.send['/cmd_vel'](Twist(), '/node_1')
    FakeSubscriber.made['/cmd_vel'].nodes.clear()       # it was killed
    rig.expect(made, 0.2)
    rig.send['/cmd_vel'](Twist(), '/node_2')
    assert rig.said == []
    FakeSubscriber.made['/cmd_vel'].nodes.add('/node_1')
    rig.expect(made, 0.3)
    rig.send['/cmd_vel'](Twist(), '/node_1')
    assert '/node_1, /node_2 publish on /cmd_vel' in rig.said[0]


@pytest.mark.parametrize('topic, kind', [
    ('/image', Image), ('/marker', Marker), ('/header', Header), ('/cmd_vel', TwistStamped)])
def test_a_message_with_a_header_answers_what_is_not_newer(rig, topic, kind):
    def msg(time_s):
        header = Header(stamp=rospy.Time.from_sec(time_s))
        return header if kind is Header else kind(header=header)

    made = rig.make(topic)
    assert rig.expect(made, 0.2)
    rig.send[topic](msg(0.1999))
    assert rig.waits(made)
    rig.send[topic](msg(0.2))
    assert not rig.waits(made) and rig.said == []
    assert rig.expect(made, 0.3)
    rig.send[topic](msg(1e9))
    assert not rig.waits(made)
    line, = rig.said
    assert 'has the stamp 1000000000.000 s, but it is 0.300 s: give it the stamp' in line


def test_a_topic_of_a_robot_answers_only_its_sensors(rig):
    made = rig.make('a/answer, b/answer  both')
    for time_s, measured, topics in ((0.1, ['a'], ['/a/answer', '/both']),
                                     (0.2, ['a', 'b'], ['/a/answer', '/both', '/b/answer'])):
        assert rig.expect(made, time_s, measured, ['a', 'b'])
        for topic in topics:
            assert rig.waits(made)
            rig.send[topic](Twist())
        assert not rig.waits(made)


def test_a_topic_of_a_robot_of_a_simulator_in_a_namespace(rig, monkeypatch):
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: '/sim/' + name)
    made = rig.make('a/answer')
    assert not rig.expect(made, 0.1, ['b'], ['a', 'b'])
    assert rig.expect(made, 0.2, ['a'], ['a', 'b'])


def test_a_robot_that_is_removed_does_not_answer(rig):
    made = rig.make('a/answer b/answer')
    rig.expect(made, 0.1, ['a', 'b'], ['a', 'b'])
    rig.send['/a/answer'](Twist())
    made.forget('b')
    assert not rig.waits(made)
    assert rig.expect(made, 0.2, ['a'], ['a'])
    rig.send['/a/answer'](Twist())
    assert not rig.waits(made) and rig.said == []
    assert rig.expect(made, 0.3, ['b'], ['a', 'b'])


def test_a_pause_is_no_time_without_an_answer(rig):
    made = rig.make('cmd_vel')
    rig.expect(made, 0.1)
    rig.gate.change('pause')
    rig.wall_s += 100.0
    rig.gate.change('unpause')
    assert rig.waits(made)
    rig.wall_s += 5.0
    assert not rig.waits(made)


def test_time_goes_on_after_the_timeout_and_waits_again_after_an_answer(rig):
    made = rig.make('cmd_vel', lockstep_timeout=12.0)
    rig.expect(made, 0.1)
    for wall_s, lines in ((1004.9, 0), (1005.0, 1), (1009.9, 1), (1010.0, 2), (1011.9, 2)):
        rig.wall_s = wall_s
        assert rig.waits(made) and len(rig.said) == lines
    assert rig.said[1] == ('simulation paused: waiting for a message on /cmd_vel (simulated time '
                           'is 0.100 s)')
    rig.wall_s = 1012.0
    assert not rig.waits(made)
    assert rig.said[2] == (
        'lockstep: no answer in 12 s to what was measured at 0.100 s: /cmd_vel has had no message '
        'yet. Time goes on, and waits for it again when it answers')
    assert not rig.expect(made, 0.2)
    rig.send['/cmd_vel'](Twist())
    assert rig.said[3] == ('lockstep: /node answers on /cmd_vel again: simulated time waits for '
                           'it') and len(rig.said) == 4
    assert rig.expect(made, 0.3)
    FakeSubscriber.made['/cmd_vel'].nodes.clear()
    rig.wall_s = 2000.0
    assert not rig.waits(made)
    assert '/cmd_vel is published by nobody any more (before: /node)' in rig.said[4]


def test_a_bag_that_plays_what_the_simulator_publishes(rig):
    rig.others = [('/scan', ['/play_1', '/play_2'])]
    assert not rig.waits(rig.make('cmd_vel'))
    assert rig.said == ['lockstep: /scan is published by /play_1, /play_2 too: nodes answer their '
                        'messages as well; stop them']


def test_time_begins_when_all_are_connected(rig):
    made = rig.make('cmd_vel')
    rig.unconnected = ['a publisher of /cmd_vel']
    assert rig.waits(made) and rig.said == []
    rig.wall_s += 5.0
    assert rig.waits(made)
    assert rig.said == ['simulation paused: waiting for a publisher of /cmd_vel (simulated time '
                        'is 0.000 s)']
    rig.unconnected = []
    assert not rig.waits(made)


@pytest.mark.parametrize('topics, asked', [
    ('answer', {'/answer': '*'}),
    ('cmd_vel answer', {'/cmd_vel': 'geometry_msgs/Twist', '/answer': '*'})])
def test_only_publishers_of_answers_are_needed(rig, topics, asked):
    rig.waits(rig.make(topics))
    assert rig.asked == asked


def test_a_command_topic_of_a_robot_that_is_added_later(rig):
    made = rig.make('late/cmd_vel')
    other = FakeSubscriber.made['/late/cmd_vel']
    made.subscribe_commands('late/cmd_vel', Twist, rig.commands.append)
    assert other.nodes is None and rig.expect(made, 0.1)
    FakeSubscriber.made['/late/cmd_vel'].send(Twist())
    assert not rig.waits(made) and len(rig.commands) == 1


def test_a_node_that_hears_only_from_others_and_comes_back(rig):
    made, delivered = rig.make('cmd_vel', lockstep_timeout=9.0), []
    made.redelivery.deliver = lambda to_all=False: to_all and delivered.append(
        rig.wall_s - began_s)
    for begin_s, again in ((0.1, [3.0]), (0.2, [])):
        began_s = rig.wall_s
        assert rig.expect(made, begin_s)
        for _ in range(12):
            rig.wall_s += 0.5
            if rig.wall_s >= began_s + 1.5 and again:
                rig.uris = {'/node': 'http://a:2'}      # it was started again
            assert rig.waits(made)
        assert delivered == again
        rig.send['/cmd_vel'](Twist())
        assert not rig.waits(made)
        delivered.clear()


@pytest.mark.parametrize('is_awaited', [True, False])
def test_a_reset_drops_only_the_answer_before_it(rig, is_awaited):
    made, dropped = rig.make('cmd_vel'), []

    def take():
        return made.take_due(lambda: dropped.append(True))
    assert not take()
    rig.expect(made, 0.1)
    if not is_awaited:
        assert take()
    made.notify_reset()
    if is_awaited:
        assert take() and dropped.pop()
    rig.expect(made, 0.2)
    assert take() and not take() and dropped == []


def test_a_topic_that_the_simulator_publishes_is_refused(rig):
    made = rig.make('cmd_vel odom')
    with pytest.raises(UserError, match='lockstep: /odom is published by the simulator itself'):
        rig.waits(made)


def test_no_topic():
    assert LockstepSettings().topics == LockstepSettings('none').topics == ()
    assert LockstepSettings('a, b').topics == ('/a', '/b')


@pytest.mark.parametrize('wrong, allowed', [
    ({'lockstep': ''}, 'names of topics, or none'),
    ({'lockstep': 'cmd_vel 3rd'}, 'names of topics, or none'),
    ({'lockstep_sensors': 'image sonar'}, 'some of image, scan, odom, imu, joint_states'),
    ({'lockstep_sensors': ' '}, 'some of image')])
def test_wrong_settings(wrong, allowed):
    with pytest.raises(SettingError, match=allowed):
        LockstepSettings(**wrong)
