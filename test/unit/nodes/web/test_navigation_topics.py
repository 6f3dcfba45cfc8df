"""What pages get of a map, transforms and plans, and what they send, without a master."""
import base64

import cv2
import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Path
from tf2_msgs.msg import TFMessage

from img_recog.errors import UserError
from img_recog.nodes.web import navigation_topics
from img_recog.nodes.web.navigation_topics import NavigationTopics

TYPES = {'/map': 'nav_msgs/OccupancyGrid', '/move_base/plan': 'nav_msgs/Path',
         '/tb3_1/plan': 'nav_msgs/Path', '/odom': 'nav_msgs/Odometry'}


class Publisher:
    """Keeps what is published, by topics."""

    sent = {}

    def __init__(self, name, *_, **__):
        self._name = name

    def publish(self, msg):
        self.sent[self._name] = msg


@pytest.fixture
def topics(monkeypatch):
    """Those of a robot without a namespace, with a map."""
    monkeypatch.setattr(navigation_topics.rospy, 'Publisher', Publisher)
    monkeypatch.setattr('rospy.Time.now', lambda: None)
    made = NavigationTopics('/{}'.format, lambda: 'odom')
    made.follow(TYPES)
    return made


def calls(topics):
    return {name: callback for name, _, callback in topics.topics()}


def found(topics):
    return topics.updates.since(None)[1]


def grid(cells, frame='map', resolution=0.5):
    msg = OccupancyGrid()
    msg.header.frame_id = frame
    msg.info.height, msg.info.width = np.shape(cells)
    msg.info.resolution = resolution
    msg.info.origin.position.x, msg.info.origin.orientation.w = -1.0, 1.0
    msg.data = np.ravel(cells).astype(np.int8)
    return msg


def shown(topics):
    """Return the grays of the map, the lowest row first, and its corner."""
    sent = found(topics)['map']
    image = cv2.imdecode(np.frombuffer(base64.b64decode(sent['png']), np.uint8), -1)
    return image.tolist(), sent['corner']


CELLS = [[-1, -1, -1, -1], [-1, 0, 100, -1], [-1, -1, 50, -1]]


def test_only_with_a_map_there_is_something(topics):
    assert topics.has_map
    assert set(calls(topics)) == {'/map', '/tf', '/tf_static', '/move_base/plan', '/tb3_1/plan'}
    topics.follow({'/move_base/plan': 'nav_msgs/Path', '/map': 'std_msgs/String'})
    assert not topics.has_map and topics.topics() == []


def test_a_robot_has_its_own_map_or_that_of_all(topics):
    robot = NavigationTopics('/tb3_1/{}'.format, lambda: 'tb3_1/odom')
    robot.follow(TYPES)
    assert set(calls(robot)) == {'/map', '/tf', '/tf_static', '/tb3_1/plan'}
    robot.follow({**TYPES, '/tb3_1/map': 'nav_msgs/OccupancyGrid'})
    assert '/tb3_1/map' in calls(robot) and '/map' not in calls(robot)


def test_the_known_part_of_the_map_is_shown_and_updated(topics):
    calls(topics)['/map'](grid(CELLS))
    assert shown(topics) == ([[254, 0], [205, 127]], [-0.5, 0.5, 0.0])
    update = pytest.importorskip('map_msgs.msg').OccupancyGridUpdate
    topics.follow({**TYPES, '/map_updates': 'map_msgs/OccupancyGridUpdate'})
    calls(topics)['/map_updates'](update(x=1, y=2, width=1, height=1, data=[100]))
    assert shown(topics)[0] == [[254, 0], [0, 127]]
    calls(topics)['/map_updates'](update(x=3, y=2, width=2, height=1, data=[100, 100]))
    assert shown(topics)[0] == [[254, 0], [0, 127]]


@pytest.mark.parametrize('change', [
    {'data': [0]}, {'resolution': float('nan')}, {'resolution': 0.0}, {'width': 0}, {'turn': 0.0}])
def test_a_bad_map_is_not_shown(topics, change):
    msg = grid(CELLS, resolution=change.get('resolution', 0.5))
    msg.data, msg.info.width = change.get('data', msg.data), change.get('width', 4)
    msg.info.origin.orientation.w = change.get('turn', 1.0)
    calls(topics)['/map'](msg)
    assert found(topics) == {}


def transforms():
    """Return one from odom, and that from map to odom: 1.5 m ahead, turned to the left."""
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = 'map', '/odom'
    transform.transform.translation.x = 1.5
    transform.transform.rotation.z = transform.transform.rotation.w = np.sqrt(0.5)
    other = TransformStamped(child_frame_id='base_footprint')
    other.header.frame_id = 'odom'
    return TFMessage([other]), TFMessage([transform])


def test_a_static_transform_can_come_before_the_map(topics):
    moves, static = transforms()
    calls(topics)['/tf_static'](static)
    calls(topics)['/tf'](moves)
    assert 'origin' not in found(topics)
    calls(topics)['/map'](grid(CELLS))
    calls(topics)['/tf'](moves)
    assert found(topics)['origin'] == [1.5, 0.0, pytest.approx(np.pi / 2, abs=1e-4)]


def test_transforms_and_plans_in_the_frames_of_map_and_odometry(topics):
    calls(topics)['/map'](grid(CELLS))
    moves, static = transforms()
    calls(topics)['/tf'](TFMessage([*moves.transforms, *static.transforms, *moves.transforms]))
    assert found(topics)['origin'] == [1.5, 0.0, pytest.approx(np.pi / 2, abs=1e-4)]
    sent, _ = topics.updates.since(None)
    calls(topics)['/tf'](moves)     # of other frames
    assert topics.updates.since(sent) == (sent, {})
    plan = Path(poses=[PoseStamped() for _ in range(3)])
    plan.header.frame_id = 'odom'
    plan.poses[1].pose.position.x, plan.poses[2].pose.position.y = 2.0, float('nan')
    calls(topics)['/move_base/plan'](plan)
    assert found(topics)['plans'] == [{'in_odom': True, 'points': [(0.0, 0.0), (2.0, 0.0)]}]


def test_goals_and_initial_poses(topics):
    calls(topics)['/map'](grid(CELLS))
    topics.publish(1.0, 2.0, np.pi / 2, False)
    goal = Publisher.sent['/move_base_simple/goal']
    assert (goal.header.frame_id, goal.pose.position.y) == ('map', 2.0)
    assert goal.pose.orientation.z == pytest.approx(np.sqrt(0.5))
    topics.publish(3.0, 2.0, 0.0, True)
    initial = Publisher.sent['/initialpose']
    assert (initial.header.frame_id, initial.pose.pose.position.x) == ('map', 3.0)
    assert [initial.pose.covariance[each] for each in (0, 7, 35)] == pytest.approx(
        [0.25, 0.25, 0.0685], abs=1e-4)
    with pytest.raises(UserError, match='cannot move the robot'):
        topics.publish(float('nan'), 2.0, 0.0, False)
