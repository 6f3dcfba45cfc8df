"""Simulated time as others see it: /clock, and how fast it passes."""
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from img_recog.conversions import robot_msgs
from img_recog.ros import master_calls
from img_recog.ros.transport import own_time
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation.pacing import Pace
from img_recog.simulation.simulator import Simulator


class SimulatedClock:
    """Publishes /clock (rosgraph_msgs/Clock) and ~real_time_factor (std_msgs/Float64)."""

    def __init__(self, simulator: Simulator, pace: Pace):
        """Advertise; log a warning if another node publishes /clock."""
        self._simulator, self._pace = simulator, pace
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
