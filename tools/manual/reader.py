"""What the reader of the e-Manual would do, as a node: drive, look at the map, give goals."""
import math
import threading
import time
from typing import NamedTuple, Tuple

import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from explorer import Round, command
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from occupancy import Grid
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from img_recog import rotations
from img_recog.conversions.plane_msgs import PlanePose, initial_pose, pose_to_msg
from img_recog.errors import UserError
from img_recog.messages import message

_FIRST_S, _MAP_S = 60, 10           # of wall time
_EXPLORE_S, _GOAL_S = 300, 180      # simulated
_POLL_S, _LANE_POLL_S = 0.1, 0.02
_ENDS = {GoalStatus.SUCCEEDED: message('reached'), GoalStatus.ABORTED: message('given up'),
         GoalStatus.PREEMPTED: message('preempted'), GoalStatus.REJECTED: message('rejected')}


class Arrival(NamedTuple):
    """How a goal ended.

    is_reached: says move_base. text: the same for the user. position: the true one in the world,
    m. time_s: simulated.
    """

    is_reached: bool
    text: str
    position: Tuple[float, float]
    time_s: float


class Reader:
    """A node that waits for the simulator when it is made.

    is_running: says whether the nodes of the chapter may still answer.
    """

    def __init__(self):
        self.is_running = lambda: True
        rospy.init_node('manual', disable_signals=True)
        self._newest, self._changed = {}, threading.Condition()
        for topic, kind in (('odom', Odometry), ('scan', LaserScan), ('map', OccupancyGrid),
                            ('amcl_pose', PoseWithCovarianceStamped),
                            ('move_base/status', GoalStatusArray)):
            rospy.Subscriber(topic, kind, self._take, topic)
        self._velocity = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        self._initial = rospy.Publisher('initialpose', PoseWithCovarianceStamped, queue_size=1)
        self._goal = rospy.Publisher('move_base_simple/goal', PoseStamped, queue_size=1)
        self._wait('odom')

    def _take(self, msg, topic):
        with self._changed:
            self._newest[topic] = msg
            self._changed.notify_all()

    def _wait(self, topic, timeout_s=_FIRST_S, is_right=lambda msg: True):
        """Return the newest message of a topic that is right, when there is one."""
        end = time.monotonic() + timeout_s
        with self._changed:
            while topic not in self._newest or not is_right(self._newest[topic]):
                if time.monotonic() > end or not self.is_running():
                    raise UserError(
                        message('no message on /{} for {} s', topic, timeout_s)
                        if self.is_running() else
                        message('no message on /{} before roslaunch has ended', topic),
                        message('see what the nodes have printed above'))
                self._changed.wait(_POLL_S)
            return self._newest[topic]

    def position(self):
        """Return the true x and y in the world, m: the simulator's odometry is that."""
        where = self._newest['odom'].pose.pose.position
        return where.x, where.y

    def yaw(self):
        """Return the true heading in the world, rad."""
        turn = self._newest['odom'].pose.pose.orientation
        return rotations.yaw((turn.x, turn.y, turn.z, turn.w))

    def explore(self):
        """Follow the wall until the robot is back where it has begun."""
        self._wait('map')
        turn, end = Round(self.position()), rospy.get_time() + _EXPLORE_S
        while not turn.is_complete(self.position()):
            if rospy.get_time() > end:
                raise UserError(
                    message('the robot is not back where it has begun after {} s, {} m',
                            _EXPLORE_S, '{:.1f}'.format(turn.driven_m)),
                    message('is the world turtlebot3_world?'))
            scan, twist = self._wait('scan'), Twist()
            twist.linear.x, twist.angular.z = command(scan.ranges, scan.angle_min,
                                                      scan.angle_increment)
            self._velocity.publish(twist)
            rospy.sleep(_POLL_S)
        self._velocity.publish(Twist())

    def grid(self, is_new=True):
        """Return the next map, which has what the robot has seen so far; or the one there is."""
        now = rospy.Time.now()
        msg = self._wait('map', _FIRST_S + _MAP_S,
                         lambda msg: not is_new or msg.header.stamp > now)
        info = msg.info
        return Grid(np.array(msg.data, np.int8).reshape(info.height, info.width),
                    info.resolution, (info.origin.position.x, info.origin.position.y))

    def follow_lane(self, take, is_done, most_s):
        """Pass the true pose on until all is done, but for `most_s` of simulated time at most.

        Returns the simulated time, the number of images that were searched, and of those in which
        a lane was found: detect_lane counts the third part of the images.
        """
        counts = {'white_line_reliability': 0, 'lane': 0}
        for topic in counts:
            rospy.Subscriber('detect/' + topic, rospy.AnyMsg,
                             lambda _, topic=topic: counts.update({topic: counts[topic] + 1}))
        end = time.monotonic() + _FIRST_S
        while not counts['lane']:
            if time.monotonic() > end or not self.is_running():
                raise UserError(message('detect_lane has found no lane'),
                                message('see what the nodes have printed above'))
            time.sleep(_POLL_S)
        begin_s = rospy.get_time()
        while not is_done() and rospy.get_time() < begin_s + most_s and self.is_running():
            take(*self.position(), self.yaw())
            time.sleep(_LANE_POLL_S)
        return rospy.get_time() - begin_s, *counts.values()

    def localize(self, start):
        """Say where the robot is, as by "2D Pose Estimate" of rviz, until amcl has it."""
        msg = initial_pose(pose_to_msg(PlanePose(*start, 0.0), Header(frame_id='map')))

        def is_there(pose):
            where = pose.pose.pose.position
            return math.dist((where.x, where.y), start) < 0.5
        self._until(lambda: self._initial.publish(msg), lambda: 'amcl_pose' in self._newest
                    and is_there(self._newest['amcl_pose']),
                    message('amcl has no pose near the start after {} s', _FIRST_S))

    def _until(self, action, is_done, problem):
        end = time.monotonic() + _FIRST_S
        while not is_done():
            if time.monotonic() > end:
                raise UserError(problem, message('see what the nodes have printed above'))
            action()
            time.sleep(1.0)

    def _goals(self):
        """Return the status of each goal that move_base knows."""
        return {status.goal_id.id: status.status for status in
                self._newest['move_base/status'].status_list}

    def drive_to(self, goal):
        """Give a goal, as by "2D Nav Goal" of rviz; return how it ended, an Arrival.

        goal: x, y in m and yaw in rad.
        """
        self._wait('move_base/status')
        self._until(lambda: None, lambda: self._goal.get_num_connections() > 0,
                    message('move_base takes no goal after {} s', _FIRST_S))
        before, start = set(self._goals()), rospy.get_time()
        self._goal.publish(pose_to_msg(PlanePose(*goal), Header(stamp=rospy.Time.now(),
                                                                frame_id='map')))
        while rospy.get_time() < start + _GOAL_S:
            ended = [status for name, status in self._goals().items()
                     if name not in before and status in _ENDS]
            if ended:
                break
            time.sleep(_POLL_S)
        return Arrival(GoalStatus.SUCCEEDED in ended,
                       _ENDS[ended[0]] if ended else message('not reached'),
                       self.position(), rospy.get_time() - start)
