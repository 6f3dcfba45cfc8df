"""When simulated time may pass: each mode, each wait, and what happens in any order."""
import itertools
from concurrent.futures import ThreadPoolExecutor

import pytest
import rospy
from hypothesis import given, settings
from hypothesis import strategies as st

from img_recog.errors import SimulationError
from img_recog.nodes.gazebo import time_gate
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate, Wait

TIMEOUT_S, REPORT_S = 12.0, 5.0
HERE = 100          # steps of the physics until now; a call of ~step ends 10 later
MODES = {Mode.PAUSED: ['pause'], Mode.STEP_THEN_PAUSE: ['pause', 'step'],
         Mode.STEP_THEN_RUN: ['pause', 'step', 'unpause'], Mode.RUNNING: [],
         Mode.SHUT_DOWN: ['shut_down']}


class Rig:
    """A gate, what it has called and logged, and the time of the wall."""

    def __init__(self, is_lockstep=True):
        self.now_s, self.woken, self.ended, self.said = 1000.0, 0, 0, []
        self.gate = TimeGate(Mode.RUNNING, self.wake, TIMEOUT_S if is_lockstep else None)

    def wake(self):
        self.woken += 1

    def end_call(self):
        self.ended += 1

    def do(self, event):
        """Let the event happen; return whether it is refused."""
        try:
            if event == 'step':
                self.gate.step(HERE + 10, self.end_call)
            else:
                self.gate.change(event)
        except SimulationError as error:
            return str(error)
        return ''


@pytest.fixture
def make(monkeypatch):
    """A function that makes a Rig, whose time is that of the gate."""
    def make_rig(is_lockstep=True):
        made = []
        monkeypatch.setattr(time_gate.time, 'monotonic', lambda: made[0].now_s if made else 1000.0)
        made.append(Rig(is_lockstep))
        monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: made[0].said.append(
            text % values))
        return made[0]
    return make_rig


@pytest.fixture
def rig(make):
    return make()


PAUSED, STEP_THEN_PAUSE, STEP_THEN_RUN, RUNNING, SHUT_DOWN = Mode
NOT_PAUSED = 'the physics is not paused'


@pytest.mark.parametrize('event, before, after, refusal', [
    ('pause', PAUSED, PAUSED, ''), ('pause', STEP_THEN_PAUSE, STEP_THEN_PAUSE, ''),
    ('pause', STEP_THEN_RUN, STEP_THEN_PAUSE, ''), ('pause', RUNNING, PAUSED, ''),
    ('pause', SHUT_DOWN, SHUT_DOWN, ''),
    ('unpause', PAUSED, RUNNING, ''), ('unpause', STEP_THEN_PAUSE, STEP_THEN_RUN, ''),
    ('unpause', STEP_THEN_RUN, STEP_THEN_RUN, ''), ('unpause', RUNNING, RUNNING, ''),
    ('unpause', SHUT_DOWN, SHUT_DOWN, ''),
    ('step', PAUSED, STEP_THEN_PAUSE, ''),
    ('step', STEP_THEN_PAUSE, STEP_THEN_PAUSE, 'another call of ~step'),
    ('step', STEP_THEN_RUN, STEP_THEN_RUN, NOT_PAUSED), ('step', RUNNING, RUNNING, NOT_PAUSED),
    ('step', SHUT_DOWN, SHUT_DOWN, NOT_PAUSED),
    ('end_step', PAUSED, PAUSED, ''), ('end_step', STEP_THEN_PAUSE, PAUSED, ''),
    ('end_step', STEP_THEN_RUN, RUNNING, ''), ('end_step', RUNNING, RUNNING, ''),
    ('end_step', SHUT_DOWN, SHUT_DOWN, ''),
    *(('shut_down', mode, SHUT_DOWN, '') for mode in Mode)])
def test_each_event_in_each_mode(rig, event, before, after, refusal):
    for each in MODES[before]:
        rig.do(each)
    assert rig.gate.mode is before
    had_ended, is_stepping = rig.ended, before in (STEP_THEN_PAUSE, STEP_THEN_RUN)
    found = rig.do(event)
    assert refusal in found and bool(refusal) == bool(found)
    assert rig.gate.mode is after
    # the call of ~step ends once
    assert rig.ended - had_ended == (is_stepping and event in ('end_step', 'shut_down'))
    assert rig.gate.is_paused == (after in (PAUSED, STEP_THEN_PAUSE))


@pytest.mark.parametrize('mode, may_pass, end, is_over', [
    (PAUSED, '..', 0, '..'), (STEP_THEN_PAUSE, 'y.', HERE + 10, '.y'),
    (STEP_THEN_RUN, 'y.', HERE + 10, '.y'), (RUNNING, 'yy', HERE + 99, '..'),
    (SHUT_DOWN, '..', 0, '..')])
def test_how_far_time_passes_in_each_mode(rig, mode, may_pass, end, is_over):
    for each in MODES[mode]:
        rig.do(each)
    for steps, passes, over in zip((HERE, HERE + 10), may_pass, is_over):
        assert rig.gate.may_pass(steps) == (passes == 'y')
        assert rig.gate.is_step_over(steps) == (over == 'y')
    assert rig.gate.end_of(HERE + 99) == end
    assert rig.gate.end_of(HERE + 1) == min(end, HERE + 1)


@pytest.mark.parametrize('wait, mode', itertools.product(Wait, (STEP_THEN_PAUSE, RUNNING)))
def test_each_wait_holds_time_until_it_ends(rig, wait, mode):
    for each in MODES[mode]:
        rig.do(each)
    rig.gate.expect(wait, ['a', 'b'])
    rig.gate.end(wait, 'c')
    for left in ('a', 'b'):
        assert not rig.gate.may_pass(HERE) and not rig.gate.is_step_over(HERE + 10)
        assert left in rig.gate.awaited(*Wait) and rig.woken == 0
        rig.gate.end(wait, left)
    assert rig.gate.may_pass(HERE) and rig.gate.awaited(*Wait) == set() and rig.woken == 1
    rig.gate.expect(wait, ['a', 'b'])
    rig.gate.expect(wait, ['c'])        # in place of the others
    rig.gate.expect(wait, ())
    assert rig.gate.may_pass(HERE)
    rig.gate.expect(wait, ['a'])
    rig.do('shut_down')
    rig.gate.expect(wait, ['a'])
    assert rig.gate.awaited(*Wait) == set() and not rig.gate.may_pass(HERE)


def test_only_the_last_wait_wakes_the_loop(rig):
    for wait in Wait:
        rig.gate.expect(wait, ['a'])
    for count, wait in enumerate(Wait, 1):
        assert rig.woken == 0
        rig.gate.end(wait, 'a')
    assert rig.woken == 1


def test_free_run_waits_only_for_the_world(make):
    rig = make(is_lockstep=False)
    for wait in Wait:
        rig.gate.expect(wait, ['a'])
    assert rig.gate.awaited(*Wait) == {'a'} == rig.gate.awaited(Wait.LOADING)
    assert not rig.gate.may_pass(HERE)
    rig.gate.expect(Wait.LOADING, ())
    rig.do('pause')
    assert not rig.gate.may_pass(HERE)
    rig.gate.expect(Wait.LOADING, ['a'])        # time has not passed yet
    rig.do('unpause')
    assert not rig.gate.may_pass(HERE)
    rig.gate.expect(Wait.LOADING, ())
    assert rig.gate.may_pass(HERE)
    rig.gate.expect(Wait.LOADING, ['a'])
    assert rig.gate.may_pass(HERE)


def test_timeout_counts_from_sending_without_pauses(rig):
    gate = rig.gate
    gate.expect(Wait.ANSWERS, ['a', 'b'])
    rig.now_s += 100.0
    assert gate.overdue() == set() and not gate.is_sent
    gate.notify_sent()
    rig.now_s += TIMEOUT_S - 0.5
    gate.notify_sent()                  # changes nothing
    gate.end(Wait.ANSWERS, 'a')
    assert gate.overdue() == set()
    rig.now_s += 0.5
    assert gate.overdue() == {'b'} and not gate.may_pass(HERE)
    rig.do('pause')
    rig.now_s += 100.0
    rig.do('step')
    assert gate.overdue() == set()
    rig.now_s += TIMEOUT_S
    assert gate.overdue() == {'b'}
    gate.expect(Wait.ANSWERS, ['a'])
    assert gate.overdue() == set()


@pytest.mark.parametrize('wait, what, line', [
    (Wait.LOADING, ['the world'], 'the process that draws to load the world'),
    (Wait.IMAGES, [7], 'the process that draws to draw the images of the cameras'),
    (Wait.CONNECTIONS, ['a publisher of /b', 'a publisher of /a'],
     'a publisher of /a; a publisher of /b'),
    (Wait.SENSOR, ['image'], 'a sensor of the kind image; no robot has one, or no node subscribes '
     'to the images'),
    (Wait.ANSWERS, ['/cmd_vel from /my_node'], 'a message on /cmd_vel from /my_node')])
def test_awaited_things_are_logged_every_5_s(rig, wait, what, line):
    def say():
        rig.gate.report(1.5)
        found, rig.said = rig.said, []
        return found
    lines = ['simulation paused: waiting for {} (simulated time is 1.500 s)'.format(line)]
    rig.gate.expect(wait, what)
    rig.gate.notify_sent()
    for later_s, expected in ((0.0, []), (4.9, []), (0.2, lines), (4.9, []), (0.2, lines)):
        rig.now_s += later_s
        assert say() == expected
    rig.now_s += 100.0
    rig.do('pause')
    assert say() == []
    rig.do('unpause')
    rig.gate.expect(wait, ())
    assert say() == [] and rig.gate.may_pass(HERE)
    rig.gate.expect(wait, what)         # time has just passed
    assert say() == []


def test_pause_delays_the_line_about_answers(rig):
    rig.gate.expect(Wait.ANSWERS, ['a'])
    rig.gate.notify_sent()
    rig.do('pause')
    rig.now_s += 100.0
    rig.do('unpause')
    rig.gate.report(1.0)
    assert rig.said == []
    rig.now_s += REPORT_S
    rig.gate.report(1.0)
    assert len(rig.said) == 1


def test_answers_in_several_threads_wake_the_loop_once(rig):
    topics = ['/topic_{}'.format(number) for number in range(8)]
    with ThreadPoolExecutor(len(topics)) as threads:
        for turn in range(1, 51):
            rig.gate.expect(Wait.ANSWERS, topics)
            list(threads.map(lambda topic: rig.gate.end(Wait.ANSWERS, topic), topics))
            assert rig.woken == turn and rig.gate.may_pass(HERE)


EVENTS = st.one_of(
    st.sampled_from(['pause', 'unpause', 'step', 'end_step', 'notify_sent', 'give_up', 'pass']),
    st.tuples(st.just('expect'), st.sampled_from(Wait), st.sets(st.sampled_from('abc'))),
    st.tuples(st.just('end'), st.sampled_from(Wait), st.sampled_from('abc')),
    st.tuples(st.just('later'), st.sampled_from([1.0, TIMEOUT_S])))


class Model:
    """What the gate is to do, said without its table: flags, and a set of what is awaited."""

    def __init__(self, is_lockstep):
        self.is_lockstep, self.has_passed = is_lockstep, False
        self.is_paused, self.step_end, self.steps = False, None, HERE
        self.awaited, self.sent_s = set(), None

    def may_pass(self):
        if self.awaited:
            return False
        return not self.is_paused if self.step_end is None else self.steps < self.step_end


@settings(max_examples=200, deadline=None, derandomize=True)
@given(is_lockstep=st.booleans(), events=st.lists(EVENTS, max_size=40))
def test_time_passes_exactly_when_it_may(is_lockstep, events):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rospy, 'logwarn', lambda *_: None)
        now = [1000.0]
        patch.setattr(time_gate.time, 'monotonic', lambda: now[0])
        rig, model = Rig(is_lockstep), Model(is_lockstep)
        for event in events:
            follow(rig, model, now, event)
            may_pass = rig.gate.may_pass(model.steps)
            assert may_pass == model.may_pass()
            model.has_passed |= may_pass
            assert rig.gate.awaited(*Wait) == {what for _, what in model.awaited}
        # all ends: by its events, by the timeout, or by the shutdown
        rig.gate.notify_sent()
        now[0] += TIMEOUT_S
        assert rig.gate.overdue() == rig.gate.awaited(Wait.ANSWERS)
        rig.do('unpause')
        for wait in Wait:
            rig.gate.end(wait, *'abc')
        assert rig.gate.may_pass(model.steps) or rig.gate.is_step_over(model.steps)
        rig.gate.expect(Wait.LOADING, 'a')
        rig.do('shut_down')
        assert rig.gate.awaited(*Wait) == set() and not rig.gate.may_pass(0)


def follow(rig, model, now, event):
    """Let an event happen to the gate and the model."""
    kind, *values = [event] if isinstance(event, str) else event
    if kind == 'pass':
        end = rig.gate.end_of(model.steps + 7)
        if model.may_pass():
            assert model.steps < end <= model.steps + 7
            model.steps = end
        if rig.gate.is_step_over(model.steps):
            rig.do('end_step')
            model.step_end = None
    elif kind == 'give_up':
        late = {what for wait, what in model.awaited if wait is Wait.ANSWERS
                and model.sent_s is not None and now[0] >= model.sent_s + TIMEOUT_S}
        assert rig.gate.overdue() == late
        rig.gate.end(Wait.ANSWERS, *late)
        model.awaited -= {(Wait.ANSWERS, what) for what in late}
    elif kind == 'expect':
        wait, what = values
        rig.gate.expect(wait, what)
        model.awaited = {each for each in model.awaited if each[0] is not wait}
        if model.is_lockstep or wait is Wait.LOADING and not model.has_passed:
            model.awaited |= {(wait, each) for each in what}
        if wait is Wait.ANSWERS:
            model.sent_s = None
    elif kind == 'end':
        rig.gate.end(*values)
        model.awaited.discard(tuple(values))
    elif kind == 'later':
        now[0] += values[0]
    elif kind == 'notify_sent':
        rig.gate.notify_sent()
        model.sent_s = now[0] if model.sent_s is None else model.sent_s
    elif kind == 'step':
        is_refused = bool(rig.do('step'))
        assert is_refused == (not model.is_paused or model.step_end is not None)
        if not is_refused:
            model.step_end = HERE + 10
            model.sent_s = model.sent_s and now[0]
    else:
        if kind == 'unpause' and model.is_paused and model.step_end is None:
            model.sent_s = model.sent_s and now[0]
        rig.do(kind)
        model.is_paused = {'pause': True, 'unpause': False}.get(kind, model.is_paused)
        model.step_end = None if kind == 'end_step' else model.step_end
