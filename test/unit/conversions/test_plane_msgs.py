"""Poses and outlines in the plane."""
import math

import genpy
import numpy as np
import pytest
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovariance
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose, PoseError

HEADER = Header(stamp=genpy.Time(3, 5), frame_id='odom')


@pytest.mark.parametrize('pose', [PlanePose(0.0, 0.0, 0.0), PlanePose(-2.0, -0.5, 3.0),
                                  PlanePose(1.5, 2.5, -1.2)])
def test_a_pose_and_back(pose):
    msg = plane_msgs.pose_to_msg(pose, HEADER)
    assert msg.header == HEADER and msg.pose.position.z == 0.0
    assert plane_msgs.pose_from_msg(msg) == pytest.approx(pose)
    msg.pose.orientation.z *= 3         # it needs no unit length
    msg.pose.orientation.w *= 3
    assert plane_msgs.pose_from_msg(PoseWithCovariance(pose=msg.pose)) == pytest.approx(pose)


@pytest.mark.parametrize('change, words', [
    (lambda pose: setattr(pose.position, 'x', math.nan), 'x nan'),
    (lambda pose: setattr(pose.position, 'y', -math.inf), 'y -inf'),
    (lambda pose: setattr(pose.orientation, 'w', math.inf), 'finite'),
    (lambda pose: setattr(pose.position, 'x', -1.1e6), 'x -1.1e\\+06.*up to 1e\\+06'),
    (lambda pose: setattr(pose.orientation, 'z', 1e200), 'up to 1e\\+06'),
    (lambda pose: setattr(pose.orientation, 'w', 0.0), 'quaternion of zeros')])
def test_a_pose_that_is_refused(change, words):
    msg = PoseStamped()
    msg.pose.orientation.w = 1.0
    change(msg.pose)
    with pytest.raises(PoseError, match=words):
        plane_msgs.pose_from_msg(msg)


@pytest.mark.parametrize('origin', [PlanePose(0.0, 0.0, 0.0), PlanePose(-2.0, -0.5, 0.0),
                                    PlanePose(1.0, 2.0, math.pi / 2)])
def test_outlines_in_a_frame_that_is_elsewhere(origin):
    corners = np.array([(1.0, 2.0), (1.0, 3.0), (4.0, 2.0)])
    msg = plane_msgs.outlines_to_msg([corners], origin, 'odom', HEADER.stamp)
    seen, = plane_msgs.outlines_from_msg(msg)
    back = [origin.compose(PlanePose(*corner, 0.0))[:2] for corner in seen]
    assert np.allclose(back, corners)
    assert origin.compose(origin.inverse()) == pytest.approx((0, 0, 0))
    assert origin.inverse().compose(origin) == pytest.approx((0, 0, 0))
    if origin.yaw == 0:
        assert np.allclose(seen, corners - origin[:2])
    else:
        assert np.allclose(seen[1], (1.0, 0.0))


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf, 1.1e6, -1e300])
def test_corners_that_cannot_be_drawn_are_left_out(bad):
    outlines = [np.array([(0.0, 0.0), (bad, 0.0), (1.0, bad), (1e6, -2.0)]),
                np.array([(bad, bad), (bad, 1.0)])]
    msg = plane_msgs.outlines_to_msg([], PlanePose(0.0, 0.0, 0.0), 'odom', HEADER.stamp)
    for outline in outlines:
        msg.markers.append(Marker(type=Marker.LINE_STRIP, points=[
            Point(x, y, 0.0) for x, y in [*outline, outline[0]]]))
    msg.markers += [Marker(type=kind, points=[Point(1.0, 1.0, 0.0)] * 3)
                    for kind in (Marker.LINE_LIST, Marker.CUBE)]
    assert [each.tolist() for each in plane_msgs.outlines_from_msg(msg)] == [
        [[0.0, 0.0], [1e6, -2.0]]]


def test_outlines_and_back():
    outlines = [np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 2.0)]), np.array([(5.0, 5.0), (6.0, 7.0)])]
    msg = plane_msgs.outlines_to_msg(outlines, PlanePose(0.0, 0.0, 0.0), 'odom', HEADER.stamp)
    # earlier ones go away: there may be fewer now
    assert msg.markers[0].action == Marker.DELETEALL
    for marker in msg.markers[1:]:
        assert (marker.type, marker.action) == (Marker.LINE_STRIP, Marker.ADD)
        assert marker.header == HEADER and marker.pose.orientation.w == 1.0
        assert marker.points[0] == marker.points[-1] and marker.color.a == 1.0
    assert len({marker.id for marker in msg.markers[1:]}) == 2
    back = plane_msgs.outlines_from_msg(msg)
    assert [each.tolist() for each in back] == [each.tolist() for each in outlines]


def test_an_initial_pose_says_that_it_is_not_sure_of_x_y_and_yaw():
    msg = plane_msgs.initial_pose(plane_msgs.pose_to_msg(PlanePose(1.0, 2.0, 0.5), HEADER))
    assert msg.header == HEADER
    assert plane_msgs.pose_from_msg(msg.pose) == pytest.approx((1.0, 2.0, 0.5))
    assert np.flatnonzero(msg.pose.covariance).tolist() == [0, 7, 35]
    # as of rviz: half a meter, 15 degrees
    assert np.sqrt(msg.pose.covariance)[[0, 7, 35]] == pytest.approx([0.5, 0.5, math.radians(15)])
