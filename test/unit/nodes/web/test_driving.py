"""Who drives, and until when."""
import rosgraph

from img_recog.nodes.web import driving
from img_recog.nodes.web.driving import HOLD_S, Speeds, yield_services


class Clock:
    time_s = 0.0

    def __call__(self):
        return self.time_s


def test_a_command_holds_for_a_moment():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.current() is None
    assert speeds.hold('page', 1.0, -0.5)
    clock.time_s = HOLD_S * 0.9
    assert speeds.current() == (1.0, -0.5)
    clock.time_s = HOLD_S
    assert speeds.current() is None


def test_a_release_ends_it_at_once_but_only_for_its_owner():
    speeds = Speeds(Clock())
    speeds.hold('page', 1.0, 0.0)
    speeds.release('other')
    assert speeds.current() == (1.0, 0.0)
    speeds.release('page')
    assert speeds.current() is None


def test_the_first_who_holds_drives_until_the_end():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.hold('page', 1.0, 0.0)
    assert not speeds.hold('other', -1.0, 0.0)
    assert speeds.current() == (1.0, 0.0)
    clock.time_s = HOLD_S
    assert speeds.hold('other', -1.0, 0.0)          # the first one has stopped sending
    speeds.release('page')
    assert speeds.current() == (-1.0, 0.0)


def test_the_services_of_other_publishers(monkeypatch):
    state = ([['/cmd_vel', ['/web', '/teleop', '/foreign']], ['/odom', ['/gazebo']]], [],
             [['/teleop/yield', ['/teleop']], ['/gazebo/yield', ['/gazebo']],
              ['/foreign/get_loggers', ['/foreign']]])
    monkeypatch.setattr(driving.rospy, 'get_name', lambda: '/web')
    monkeypatch.setattr(rosgraph.Master, 'getSystemState', lambda self: state)
    assert yield_services('/cmd_vel') == ['/teleop/yield']
    assert yield_services('/nobody') == []
