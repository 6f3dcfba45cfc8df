"""Contacts as messages, and back."""
import genpy
import genpy.dynamic
import numpy as np
import pytest

from img_recog.conversions import robot_msgs
from img_recog.simulation.sensors.contact_sensor import ContactSettings, Touch
from img_recog_helpers.gazebo_messages import DEFINITIONS


@pytest.fixture(autouse=True)
def messages(monkeypatch):
    """Let the messages be there also where gazebo_msgs is not installed."""
    text = DEFINITIONS['gazebo_msgs/msg/ContactsState.msg'] + ''.join(
        '{}\nMSG: {}\n{}'.format('=' * 80, name.replace('/msg/', '/')[:-len('.msg')], definition)
        for name, definition in DEFINITIONS.items() if name.endswith('.msg'))
    made = genpy.dynamic.generate_dynamic('gazebo_msgs/ContactsState', text)
    for name in ('ContactsState', 'ContactState'):
        monkeypatch.setattr(robot_msgs, name, made['gazebo_msgs/' + name])


def test_contacts_and_back():
    points = np.array([(1.0, 2.0, 3.0), (1.0, 2.0, 4.0)])
    touches = [
        Touch('robot::bumper', 'wall::link', points, points / 5, np.array([0.01, 0.02]),
              np.array([(5.0, 0.0, 0.0), (0.0, 6.0, 1.0)]), np.array((1.0, 2.0, 2.0))),
        Touch('robot::bumper', 'post::link', points[:1], points[1:], np.array([0.5]),
              np.array([(0.0, 0.0, 7.0)]), np.zeros(3))]
    msg = robot_msgs.contacts_to_msg(touches, ContactSettings('front'), genpy.Time(3, 4))
    assert (msg.header.frame_id, msg.header.stamp) == ('front', genpy.Time(3, 4))
    first, second = msg.states
    assert (first.collision1_name, second.collision2_name) == (
        'robot::bumper::collision', 'post::link::collision')
    # about the origin of the sensor: 1 m and 2 m above it
    torques = [(each.torque.x, each.torque.y, each.torque.z) for each in first.wrenches]
    assert torques == [(0.0, 5.0, 0.0), (-12.0, 0.0, 0.0)]
    total = first.total_wrench
    assert (total.force.x, total.force.y, total.force.z) == (5.0, 6.0, 1.0)
    assert (total.torque.x, total.torque.y, total.torque.z) == (-12.0, 5.0, 0.0)
    for back, touch in zip(robot_msgs.contacts_from_msg(msg), touches):
        assert back[:2] == touch[:2] and not back.origin.any()
        for got, wanted in zip(back[2:6], touch[2:6]):
            assert got.tolist() == wanted.tolist()
    assert robot_msgs.contacts_to_msg([], ContactSettings(), genpy.Time()).states == []
