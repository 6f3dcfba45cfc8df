"""Short forms of ./run chaos and ./run test --long, which use the same functions."""
import contextlib
import re
import select

import pytest
from std_msgs.msg import String

from img_recog.ros.transport.switch import is_plain
from img_recog_helpers import wire
from img_recog_helpers.reliability import (chaos, endings, figures, files, images, long_tests,
                                           soak, surroundings, twists)
from img_recog_helpers.reliability.demo import NODES, START_LIMIT_S, STOP_LIMIT_S, Demo
from img_recog_helpers.reliability.faults import KINDS, Fault, possible
from img_recog_helpers.reliability.parts import PARTS, Options
from img_recog_helpers.reliability.nodes import Nodes
from img_recog_helpers.waiting import DEADLINE_S, stretch

# with plain rospy, a subscriber that gets damaged bytes loses its connection
NOT_PLAIN = pytest.mark.skipif(is_plain('registration'), reason='plain rospy')
SEED = 12


def factor():
    """Return the factor of all time limits: other programs may use the machine."""
    return 6.0 * stretch()


@pytest.fixture(scope='module')
def disk():
    with surroundings.SmallDisk() as disk:
        yield disk


@pytest.fixture(scope='module')
def demo(disk):
    """A running demo for all tests of this module, with a small disk for its logs."""
    with Demo() as demo:
        demo.env['ROS_LOG_DIR'] = disk.path
        demo.start_all()
        demo.chain.wait(START_LIMIT_S * factor())
        yield demo


@pytest.fixture(scope='module')
def nodes():
    with Nodes() as nodes:
        yield nodes


def test_a_short_soak(demo):
    result = soak.observe(demo, 3.0, factor())
    assert set(result.late) == set(NODES) and len(result.chain_s) >= 1


FAULTS = (
    Fault('kill', 'color_extract', ('SIGKILL',)),
    Fault('readers', 'usb_cam', (50,)),
    Fault('pause', 'usb_cam', (1.0,)),
    Fault('starve', 'gazebo', (1.0, 2)),
    Fault('master', 'master', ('SIGKILL', 0.5)))


def test_a_short_chaos(demo):
    lines = []
    run = chaos.Chaos(demo, factor(), lines.append, all_colors=False)
    run.begin()
    kinds = possible()
    assert [fault for fault in FAULTS if fault.kind in kinds and not run.apply(fault)] == [], \
        '\n'.join(lines) + demo.launch.output[-3000:]
    assert sorted(run.times_s) == sorted(kinds)
    table = chaos.report(run, factor())
    assert len(table.splitlines()) == len(kinds) + 1


def test_a_full_disk_is_not_repeated(demo, disk):
    result = surroundings.endure_full_disk(demo, disk, 2.0, factor())
    assert result['tracebacks'] == 0


def test_the_demo_ends_and_leaves_nothing(demo):
    assert demo.stop(STOP_LIMIT_S * factor()) > 0


def test_hostile_twists_and_images_in_process():
    counted = twists.in_process(20000, SEED)
    assert min(counted.values()) > 1000
    counted = images.in_process(3000, SEED)
    assert min(counted[name] for name in ('accepted', 'refused', 'undecodable')) > 100


def test_hostile_files():
    assert sum(count for count, _, _ in files.run(60, SEED)) >= 60


@NOT_PLAIN
def test_hostile_twists_and_images_over_the_wire(nodes):
    assert images.over_the_wire(500, SEED, nodes)['sent'] == 500
    assert twists.over_the_wire(600, SEED, nodes)['sent'] == 600


def test_jumps_of_the_clock(nodes):
    assert len(surroundings.clock_jumps(2, SEED, nodes, factor())) == 2


@NOT_PLAIN
def test_a_few_stops_and_kills():
    result = endings.run(lambda rng: rng.choice((endings.draw_stop, endings.draw_kill))(rng), 6,
                         SEED, factor())
    assert result.failures == [] and sum(map(len, result.times_s.values())) == 6


# The tools themselves

def test_what_comes_together_with_the_answer_to_a_subscriber_is_read(roscore):
    publisher = wire.RawPublisher(roscore.master_uri, '/latched', String, first=String('a'))
    with contextlib.closing(wire.Subscription(roscore.master_uri, wire.CALLER, '/latched',
                                              String)) as subscription:
        assert select.select([subscription.sock], [], [], DEADLINE_S)[0]
        assert [msg.data for msg in subscription.read()] == ['a']
    publisher.close()


def test_a_seed_repeats_the_faults():
    first, second, other = (
        [fault for fault, _ in zip(chaos.drawn(seed), range(50))] for seed in (1, 1, 2))
    assert first == second != other
    assert {fault.kind for fault in first} == set(KINDS)


def test_a_fault_that_is_not_survived_is_a_failure(tmp_path):
    class Broken:
        folder, launch = str(tmp_path), None

        def __getattr__(self, name):
            raise LookupError('color_extract runs 0 times')
    lines = []
    run = chaos.Chaos(Broken(), 1.0, lines.append)
    assert not run.apply(Fault('kill', 'color_extract', ('SIGKILL',)))
    assert run.failures == ['kill color_extract SIGKILL: LookupError: color_extract runs 0 times']
    assert lines == ['  FAILED ' + run.failures[0]]


def test_the_long_tests_refuse_an_unknown_part(capsys):
    with pytest.raises(SystemExit):
        long_tests.main(['soaks'])
    assert 'no part soaks; parts are {}'.format(', '.join(PARTS)) in capsys.readouterr().err


def test_a_long_test_that_fails_is_a_failure(monkeypatch, capsys):
    def fail(options):
        raise AssertionError('seed {}'.format(options.seed))
    monkeypatch.setitem(PARTS, 'clock', fail)
    rows, error = long_tests.run_part('clock', Options(5))
    assert rows == [] and 'AssertionError: seed 5' in error
    monkeypatch.setitem(PARTS, 'clock', lambda options: [('a', 'b', 'c')])
    assert long_tests.run_part('clock', Options(5)) == ([('a', 'b', 'c')], '')
    # in another process, which cannot do anything in no time
    assert long_tests.main(['clock', '--factor', '0']) == 1
    assert re.search('FAILED: clock after [0-9]+ min, seed ', capsys.readouterr().out)


def test_times():
    assert figures.seconds([3.0, 1.0, 2.0]) == ['3', '2.00', '3.00']
    assert figures.seconds([]) == ['0', '', '']
