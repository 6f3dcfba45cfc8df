"""Simulated time waits for slow subscribers, which lose no messages."""
import sys
import time

import pytest

from img_recog_testing.simulator_tools import Echo
from img_recog_testing.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master
# takes 0.1 s of wall time for each scan; tells when it was measured
SLOW = '''
import sys, time, rospy
from sensor_msgs.msg import LaserScan
def work(scan):
    end = time.monotonic() + 0.1
    {wait}
    print('scan', int(scan.header.stamp.to_nsec() / 1e6), flush=True)
rospy.init_node('slow', anonymous=True)
rospy.Subscriber('/scan', LaserScan, work, queue_size=1, tcp_nodelay=True)
rospy.spin()
'''
COMPUTE = 'while time.monotonic() < end: pass'
SLEEP = 'time.sleep(0.1)'
BUSY = 'import time, rospy\nrospy.init_node("busy")\nwhile not rospy.is_shutdown(): pass'


def scans(process):
    """Return the times of the scans that a slow subscriber has got, in ms."""
    return [int(line.split()[1]) for line in process.output.split('\n')[:-1]
            if line.startswith('scan')]


@pytest.mark.parametrize('waits', [COMPUTE, SLEEP])
def test_two_slow_subscribers_get_all_scans(ros, simulate, waits):
    node = simulate('_world:=empty', '_real_time_factor:=0', '_wait_for_subscribers:=true')
    node.wait_output('simulating 1.0017 kg')
    slow = [ros.start(sys.executable, '-c', SLOW.format(wait=waits)) for _ in range(2)]
    for each in slow:
        # after the start: the simulator looks for new nodes once a second of wall time
        wait_for(lambda: len(scans(each)) > 20, lambda: each.output)
    begun_s, counts = time.monotonic(), [len(scans(each)) for each in slow]
    for each, count in zip(slow, counts):
        wait_for(lambda: len(scans(each)) > count + 10, lambda: each.output)
        found = scans(each)[count:]
        assert {later - earlier for earlier, later in zip(found, found[1:])} == {200}, found
    assert time.monotonic() - begun_s > 10 * 0.1
    for each in slow:
        each.close()


def test_time_goes_on_without_a_node_that_never_rests(ros, simulate):
    node = simulate('_world:=empty', '_real_time_factor:=0', '_wait_for_subscribers:=true')
    node.wait_output('simulating 1.0017 kg')
    ros.set_parameters('/use_sim_time', True)
    busy, clock = ros.start(sys.executable, '-c', BUSY), Echo(ros, '/clock')
    node.wait_output('/busy: at work for more than 5 s: simulated time goes on')
    count = len(clock.rows)
    wait_for(lambda: len(clock.rows) > count + 1000, 'time that goes on')
    assert node.output.count('at work for more than') == 1
    busy.close()
