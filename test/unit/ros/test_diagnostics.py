"""Counters and their report on /diagnostics."""
import threading

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.ros import diagnostics
from img_recog.ros.diagnostics import (Durations, EventCounter, NodeDiagnostics, Refusals,
                                       add_counter, add_durations, add_refusals)
from img_recog_helpers.statuses import values
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for

OK, WARN = DiagnosticStatus.OK, DiagnosticStatus.WARN


def test_a_rate_is_that_of_the_last_three_seconds(clock, status):
    counter = EventCounter(clock)
    assert counter.rate_hz() == 0
    for expected in (10, 10, 10, 10, 10 * 2 / 3, 10 / 3, 0, 0):
        if clock.now_s < 104:
            for _ in range(10):
                counter.add()
        clock.advance(1.0)
        assert counter.rate_hz() == pytest.approx(expected)
    assert add_counter(status, 'images', counter) == 0
    assert values(status) == {'images': '40', 'images (Hz)': '0.00'}


def test_many_threads_lose_no_event():
    counter, refusals, durations = EventCounter(), Refusals(), Durations()

    def add():
        for _ in range(2000):
            counter.add()
            refusals.add('bad')
            durations.add(1.0)
    threads = [threading.Thread(target=add) for _ in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (counter.total, refusals.total, durations.take()) == (10000, 10000, (1.0, 1.0))


def test_new_refusals_are_a_warning_once(status):
    refusals = Refusals()
    assert add_refusals(status, 'images', refusals) == 0 and status.level == OK
    assert values(status) == {'images refused': '0', 'last reason': ''}
    refusals.add('too short')
    refusals.add(ValueError('no step'))
    status.values = []
    assert add_refusals(status, 'images', refusals) == 2
    assert (status.level, status.message) == (WARN, 'images refused: 2, the last: no step')
    assert values(status) == {'images refused': '2', 'last reason': 'no step'}
    status.summary(OK, 'fine')
    assert add_refusals(status, 'images', refusals) == 0 and status.level == OK


def test_a_reason_is_one_short_line():
    refusals = Refusals()
    refusals.add('a\nb\x1b[2J' + 'x' * 10 ** 7)
    assert len(refusals.last_reason) == 200 and refusals.last_reason.isprintable()
    assert refusals.last_reason.startswith('a\\nb\\x1b[2Jxxx')


def test_durations_are_those_of_the_last_period(status):
    durations = Durations()
    for seconds in (0.001, 0.004, 0.001):
        durations.add(seconds)
    add_durations(status, 'processing', durations)
    assert values(status) == {'processing, mean (ms)': '2.00', 'processing, max (ms)': '4.00'}
    status.values = []
    durations.add(0.003)
    add_durations(status, 'processing', durations)
    assert values(status) == {'processing, mean (ms)': '3.00', 'processing, max (ms)': '3.00'}
    status.values = []
    add_durations(status, 'processing', durations)
    assert values(status) == {'processing, mean (ms)': 'none', 'processing, max (ms)': 'none'}


class FakeUpdater:
    """Publishes nothing; fills in a status each time."""

    def __init__(self):
        self.filled = []

    def setHardwareID(self, name):
        self.hardware_id = name

    def add(self, name, task):
        self.name, self.task = name, task

    def force_update(self):
        self.thread = threading.current_thread()
        self.filled.append(self.task(DiagnosticStatusWrapper()))


@pytest.fixture
def updater(monkeypatch):
    """The FakeUpdater of the next NodeDiagnostics, whose period is 10 ms; it ends at shutdown."""
    made, hooks = FakeUpdater(), []
    monkeypatch.setattr(diagnostics.diagnostic_updater, 'Updater', lambda: made)
    monkeypatch.setattr(diagnostics, '_PERIOD_S', 0.01)
    monkeypatch.setattr(diagnostics.lifecycle, 'on_shutdown', hooks.append)
    yield made
    for hook in hooks:
        hook()
    made.thread.join(DEADLINE_S * stretch())        # it uses what is restored now
    assert not made.thread.is_alive()


def test_the_status_is_published_again_and_again(updater):
    NodeDiagnostics('recognition', 'none', lambda status: status.summary(WARN, 'slow'))
    wait_for(lambda: len(updater.filled) >= 3, 'three reports')
    assert (updater.name, updater.hardware_id) == ('recognition', 'none')
    last = updater.filled[-1]
    assert (last.level, last.message) == (WARN, 'slow')


def test_a_topic_that_is_closed_at_shutdown_is_no_error(updater, monkeypatch):
    raised, hidden = [], []
    monkeypatch.setattr(threading, 'excepthook', hidden.append)
    monkeypatch.setattr(rospy.core, 'is_shutdown_requested', lambda: True)

    def refuse(_):
        raised.append(rospy.ROSException('publish() to a closed topic'))
        raise raised[-1]
    NodeDiagnostics('recognition', 'none', refuse)
    wait_for(lambda: len(raised) >= 2, 'two refusals')
    assert hidden == []
