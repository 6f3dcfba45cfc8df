"""The nodes, topics, services, frames and messages of the demo, which are those of the article.

Written with img_recog.testing: simulated time passes only where a test lets it pass.
"""
import os

import numpy as np
import pytest
import rosgraph
import rospy
import tf2_ros
import yaml
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from sensor_msgs.srv import SetCameraInfo
from tf2_msgs.msg import TFMessage

from img_recog.testing import Simulation
from img_recog_helpers.recording import Diagnostics, Recorder, call, from_node
from img_recog_helpers.waiting import wait_for

NODES = {'/color_extract', '/gazebo', '/robot_state_publisher', '/turtlebot3_teleop_keyboard',
         '/usb_cam'}
TOPICS = {
    '/blue_image': 'sensor_msgs/Image',
    '/clock': 'rosgraph_msgs/Clock',
    '/cmd_vel': 'geometry_msgs/Twist',
    '/diagnostics': 'diagnostic_msgs/DiagnosticArray',
    '/imu': 'sensor_msgs/Imu',
    '/joint_states': 'sensor_msgs/JointState',
    '/odom': 'nav_msgs/Odometry',
    '/red_image': 'sensor_msgs/Image',
    '/scan': 'sensor_msgs/LaserScan',
    '/tf': 'tf2_msgs/TFMessage',
    '/tf_static': 'tf2_msgs/TFMessage',
    '/usb_cam/camera_info': 'sensor_msgs/CameraInfo',
    '/usb_cam/image_raw': 'sensor_msgs/Image',
    '/usb_cam/image_raw/compressed': 'sensor_msgs/CompressedImage',
    '/usb_cam/image_raw/compressed/parameter_descriptions':
        'dynamic_reconfigure/ConfigDescription',
    '/usb_cam/image_raw/compressed/parameter_updates': 'dynamic_reconfigure/Config',
}
SERVICES = {'/gazebo/pause_physics', '/gazebo/reset_simulation', '/gazebo/reset_world',
            '/gazebo/unpause_physics', '/usb_cam/set_camera_info', '/usb_cam/start_capture',
            '/usb_cam/stop_capture'}
# the arrows of the article's rqt_graph: (publisher, topic, subscriber)
ARROWS = {('/usb_cam', '/usb_cam/image_raw', '/color_extract'),
          ('/color_extract', '/cmd_vel', '/gazebo'),
          ('/turtlebot3_teleop_keyboard', '/cmd_vel', '/gazebo'),
          ('/gazebo', '/joint_states', '/robot_state_publisher')}
PARENTS = {'base_footprint': 'odom', 'base_link': 'base_footprint',
           'wheel_left_link': 'base_link', 'wheel_right_link': 'base_link',
           'caster_back_link': 'base_link', 'imu_link': 'base_link', 'base_scan': 'base_link',
           'camera_link': 'base_link'}
# a status of each node: a counter in it that increases, and what it measures, in ms
STATES = {'usb_cam: camera': ('frames', ['publishing a frame, max (ms)']),
          'color_extract: recognition': ('images processed', [
              'processing, max (ms)', 'stamp to commands, max (ms)']),
          'gazebo: simulation': ('sensor messages', ['clock period, max (ms)']),
          'turtlebot3_teleop_keyboard: teleop': ('commands', [])}
# of the topics of the simulator: types, and periods of simulated time in ms
PERIODS = {'/odom': (Odometry, 33), '/joint_states': (JointState, 33), '/imu': (Imu, 5),
           '/scan': (LaserScan, 200), '/tf': (TFMessage, None)}
SECONDS = 3.3


@pytest.fixture(scope='module')
def sim(tmp_path_factory):
    """The demo with the synthetic camera and the idle teleop, for all tests."""
    calibration = tmp_path_factory.mktemp('demo') / 'calibration.yaml'
    with Simulation(camera='synthetic', world='turtlebot3_world', recognition=True, teleop=True,
                    camera_info_url='file://{}'.format(calibration)) as sim:
        yield sim


@pytest.fixture(scope='module')
def sent(sim):
    """What the simulator has sent in some time, by topics."""
    topics = {name: Recorder(name, kind) for name, (kind, _) in PERIODS.items()}
    for recorder in topics.values():
        recorder.wait_connected('/gazebo')
    sim.step(SECONDS)
    for name, (_, period_ms) in PERIODS.items():
        wait_for(lambda: period_ms is None or
                 len(topics[name].messages) >= int(SECONDS * 1000 / period_ms), name)
    yield {name: list(recorder.messages) for name, recorder in topics.items()}
    for recorder in topics.values():
        recorder.close()


def state():
    """Return publishers, subscribers and providers of services, as the master knows them."""
    return [dict(entries) for entries in rosgraph.Master('/test').getSystemState()]


def test_the_graph_is_that_of_the_article(sim):
    def arrows():
        publishers, subscribers, _ = state()
        return {(source, topic, sink) for topic in publishers
                for source in publishers[topic] for sink in subscribers.get(topic, ())}
    wait_for(lambda: ARROWS <= arrows(), 'the arrows {}'.format(ARROWS))
    names = {node for kind in state() for nodes in kind.values() for node in nodes}
    types = dict(rosgraph.Master('/test').getTopicTypes())
    assert NODES <= names and SERVICES <= set(state()[2])
    assert {name: types.get(name) for name in TOPICS} == TOPICS
    assert rospy.get_param('/use_sim_time') is True


def test_every_node_reports_its_state(sim):
    states = Diagnostics()

    def is_reported(name):
        counter, measured = STATES[name]
        sim.step(0.1)
        found = states.values(name)
        counts = [int(values.get(counter, 0)) for values in found]
        # a period without an event has no measurement
        return counts and counts[-1] > counts[0] and all(
            any(0 <= float(values.get(key, 'nan')) < 60000 for values in found
                if values.get(key) != 'none') for key in measured)
    for name in STATES:
        wait_for(lambda: is_reported(name), lambda: '{} in {}'.format(name, states.values(name)))
    states.close()


def test_image_and_camera_info_have_the_same_headers(sim):
    images, infos = (Recorder('/usb_cam/' + name, kind, from_node('/usb_cam'))
                     for name, kind in (('image_raw', Image), ('camera_info', CameraInfo)))

    def pairs():
        """Return the numbers of those that have the same stamps; time passes between them."""
        sim.step(0.1)
        times = [{msg.header.stamp for msg in list(each.messages)} for each in (images, infos)]
        return times[0] & times[1]
    wait_for(lambda: len(pairs()) > 10, '10 images with their camera_info')
    for image in images.messages:
        assert (image.header.frame_id, image.encoding, image.width, image.height, image.step) == (
            'head_camera', 'rgb8', 640, 480, 1920)
    for info in infos.messages:
        assert (info.header.frame_id, info.width, info.height) == ('head_camera', 640, 480)
    # stamps are simulated time; while that stands, the next one is 1 ns later
    assert 0 < max(pairs()).to_sec() < sim.time_s + 0.001
    for each in (images, infos):
        each.close()


@pytest.mark.parametrize('topic', [name for name, (_, period) in PERIODS.items() if period])
def test_periods_in_simulated_time(sent, topic):
    times_ms = [msg.header.stamp.to_nsec() // 10**6 for msg in sent[topic]]
    period_ms = PERIODS[topic][1]
    assert set(np.diff(times_ms)) == {period_ms} and times_ms[0] % period_ms == 0


def test_the_tree_of_frames(sim, sent):
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer)

    def is_complete():
        sim.step(0.1)
        return all(buffer.can_transform('odom', frame, rospy.Time()) for frame in PARENTS)
    wait_for(is_complete, 'tf of all frames')
    frames = yaml.safe_load(buffer.all_frames_as_yaml())
    assert {child: entry['parent'] for child, entry in frames.items()} == PARENTS
    transforms = [each for msg in sent['/tf'] for each in msg.transforms]
    assert {(each.child_frame_id, each.header.frame_id) for each in transforms} == {
        ('base_footprint', 'odom'), ('wheel_left_link', 'base_link'),
        ('wheel_right_link', 'base_link')}
    stamped = [(each.child_frame_id, each.header.stamp) for each in transforms]
    assert len(set(stamped)) == len(stamped)


def test_odometry_and_joint_states(sent):
    assert {(msg.header.frame_id, msg.child_frame_id) for msg in sent['/odom']} == {
        ('odom', 'base_footprint')}
    # the order of libgazebo_ros_diff_drive
    assert {(*msg.name, len(msg.position), len(msg.velocity), len(msg.effort))
            for msg in sent['/joint_states']} == {
                ('wheel_right_joint', 'wheel_left_joint', 2, 2, 2)}


def test_scan(sent):
    for msg in sent['/scan']:
        assert (msg.header.frame_id, len(msg.ranges)) == ('base_scan', 360)
        assert (msg.angle_min + 359 * msg.angle_increment, msg.range_min, msg.range_max) == \
            pytest.approx((6.28319, 0.12, 3.5), abs=1e-5)
        ranges = np.array(msg.ranges)
        seen = ranges[np.isfinite(ranges)]
        assert len(seen) > 100 and np.all((seen >= msg.range_min) & (seen <= msg.range_max))
        assert np.all(np.isposinf(ranges[~np.isfinite(ranges)]))


def test_imu(sent):
    for msg in sent['/imu']:
        assert msg.header.frame_id == 'imu_link'
        assert msg.angular_velocity_covariance[0] == pytest.approx(4e-8)
        assert msg.linear_acceleration_covariance[0] == pytest.approx(2.89e-4)
    assert np.mean([msg.linear_acceleration.z for msg in sent['/imu']]) == pytest.approx(
        9.8, abs=0.5)


def test_the_idle_teleop_sends_zeros(sim):
    idle = Recorder('/cmd_vel', Twist, from_node('/turtlebot3_teleop_keyboard'))
    wait_for(lambda: len(idle.messages) > 10, 'Twists of the idle teleop')
    assert all(msg == Twist() for msg in idle.messages)
    idle.close()


def test_unpause_lets_time_pass_by_itself_and_pause_stops_it(sim):
    call('/gazebo/unpause_physics')
    before_s = sim.time_s
    wait_for(lambda: sim.time_s > before_s + 1.0, 'time to pass')
    call('/gazebo/pause_physics')
    sim.step(0.1)           # which a simulation that is not paused refuses
    before_s = sim.time_s
    sim.step(1.0)
    assert sim.time_s == pytest.approx(before_s + 1.0)


@pytest.mark.parametrize('service, keeps_time', [('reset_world', True),
                                                 ('reset_simulation', False)])
def test_a_reset(sim, service, keeps_time):
    def drives_away():
        sim.step(0.1)
        return abs(sim.pose().x + 2.0) > 0.05
    wait_for(drives_away, 'the robot to leave its start')
    call('/usb_cam/stop_capture')       # so that it does not leave it again
    sim.wait_until(lambda: abs(sim.pose().linear) < 0.005)
    since_s = sim.time_s if keeps_time else 0.0
    call('/gazebo/' + service)
    # after a reset of the time, it is 1 ns: rosbag cannot record a message of the time 0
    wait_for(lambda: abs(sim.time_s - since_s) < 1e-6, 'the clock, also while paused')
    after = {name: Recorder(name, kind) for name, (kind, period) in PERIODS.items() if period}
    for recorder in after.values():
        recorder.wait_connected('/gazebo')
    sim.step(0.5)
    pose = sim.pose()
    assert (pose.x, pose.y, pose.linear) == pytest.approx((-2.0, -0.5, 0.0), abs=0.02)
    assert sim.time_s == pytest.approx(since_s + 0.5)
    for name, recorder in after.items():
        wait_for(lambda: recorder.messages, name)
        recorder.close()
        assert all(since_s < msg.header.stamp.to_sec() <= sim.time_s + 1e-6
                   for msg in recorder.messages), name
    call('/usb_cam/start_capture')


def test_stop_and_start_capture(sim):
    images = Recorder('/usb_cam/image_raw', Image)
    images.wait()
    for _ in range(2):      # a second call has no effect
        call('/usb_cam/stop_capture')

    def are_old():
        """Return whether no image has come since a simulated second."""
        sim.step(1.0)
        return images.messages[-1].header.stamp.to_sec() < sim.time_s - 3.0
    wait_for(are_old, 'the last image')
    for _ in range(2):
        call('/usb_cam/start_capture')
    images.wait(5)
    images.close()


def test_a_camera_info_that_is_set_is_published_and_written(sim):
    given = CameraInfo(width=640, height=480, distortion_model='plumb_bob',
                       D=[0.1, -0.2, 0.0, 0.0, 0.01], K=[500.0, 0, 320, 0, 510.0, 240, 0, 0, 1],
                       R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                       P=[500.0, 0, 320, 0, 0, 510.0, 240, 0, 0, 0, 1, 0])
    answer = call('/usb_cam/set_camera_info', SetCameraInfo, given)
    assert answer.success, answer.status_message
    infos = Recorder('/usb_cam/camera_info', CameraInfo)
    found = wait_for(lambda: infos.messages and infos.messages[-1].K == tuple(given.K)
                     and infos.messages[-1], 'the calibration')
    infos.close()
    assert (found.D, found.P) == (tuple(given.D), tuple(given.P))
    assert os.path.basename(answer.status_message) == 'calibration.yaml'
    with open(answer.status_message) as file:
        assert 'camera_matrix' in file.read()
    given.width = 320
    refused = call('/usb_cam/set_camera_info', SetCameraInfo, given)
    assert not refused.success
    assert '320x480, the images are 640x480' in refused.status_message
