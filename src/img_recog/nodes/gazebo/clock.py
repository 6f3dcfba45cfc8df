"""Simulated time as others see it: /clock, and how fast it passes."""
from typing import Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from img_recog.conversions import robot_msgs
from img_recog.nodes.gazebo.time_gate import TimeGate
from img_recog.ros import master_calls
from img_recog.ros.diagnostics import MIN_SHARE, Durations, add_durations
from img_recog.ros.transport import own_time
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation.pacing import Pace
from img_recog.simulation.simulator import Simulator


class SimulatedClock:
    """Publishes /clock (rosgraph_msgs/Clock) and ~real_time_factor (std_msgs/Float64).

    Attributes:
        periods: Durations of the simulation of a clock period, without waiting.
    """

    def __init__(self, simulator: Simulator, pace: Pace, gate: TimeGate):
        """Advertise; log a warning if another node publishes /clock."""
        self._simulator, self._pace, self._gate = simulator, pace, gate
        self.periods = Durations()
        self._times, self._msg = DirectPublisher('/clock', Clock, latch=True), Clock()
        self._factors = rospy.Publisher('~real_time_factor', Float64, queue_size=1, latch=True)
        name = rospy.get_name()
        others = sorted(set(master_calls.calls().state().published.get('/clock', ())) - {name})
        if others:
            rospy.logwarn('/clock has another publisher, %s: two simulations mix up time, tf and '
                          'odometry; stop one of them', ', '.join(others))

    def add(self) -> None:
        """Set the time of this node, and let the next flush publish it."""
        # 0 after a reset would be no time: rosbag record would end
        now = self._msg.clock = robot_msgs.stamp_of(self._simulator.time_s or 1e-9)
        own_time.set_time(now)
        self._times.add(self._msg)

    def flush(self) -> None:
        """Publish the times that were added."""
        self._times.flush()

    def count(self, simulated_s: float) -> None:
        """Count simulated time; once a second publish the real time factor."""
        measured = self._pace.measure(simulated_s)
        if measured is not None:
            self._factors.publish(Float64(measured))
        is_slow = self._pace.take_report()
        if is_slow:
            rospy.logwarn('this machine is too slow for real_time_factor %g: simulated time falls '
                          'behind, no step is skipped; the factor is %.2f now',
                          self._pace.wanted, self._pace.measured)
        elif is_slow is not None:
            rospy.loginfo('simulated time keeps up again, the factor is %.2f', self._pace.measured)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in a status; to be called once in each period, in any thread."""
        status.summary(*_summary(self._pace, self._gate.is_paused))
        status.add('simulated time (s)', '{:.2f}'.format(self._simulator.time_s))
        status.add('real time factor', '{:.2f}'.format(self._pace.measured))
        status.add('wanted real time factor', '{:g}'.format(self._pace.wanted))
        add_durations(status, 'clock period', self.periods)


def _summary(pace: Pace, is_paused: bool) -> Tuple[int, str]:
    if is_paused:
        return DiagnosticStatus.OK, 'paused'
    if 0 < pace.measured < MIN_SHARE * pace.wanted:
        return DiagnosticStatus.WARN, (
            'too slow: real time factor {:.2f} instead of {:g}; use a smaller real_time_factor, '
            'or close windows'.format(pace.measured, pace.wanted))
    return DiagnosticStatus.OK, 'real time factor {:.2f}'.format(pace.measured)
