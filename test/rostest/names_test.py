#!/usr/bin/env python3
"""The running demo has the names of the article's system."""
import unittest

import rosgraph
import rospy
import tf2_ros
import yaml

from img_recog_helpers.recording import Diagnostics, main, wait_for

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
# a status of each node, and a counter in it that increases
COUNTERS = {'usb_cam: camera': 'frames',
            'color_extract: recognition': 'images processed',
            'gazebo: simulation': 'sensor messages',
            'turtlebot3_teleop_keyboard: teleop': 'commands'}


class NamesTest(unittest.TestCase):
    """Queries the master, like rosnode list, rostopic list and rosservice list."""

    @classmethod
    def setUpClass(cls):
        cls.master = rosgraph.Master('/names_test')

    def _state(self):
        return [dict(entries) for entries in self.master.getSystemState()]

    def test_nodes(self):
        def all_there():
            names = {node for entries in self._state() for nodes in entries.values()
                     for node in nodes}
            return NODES <= names
        wait_for(all_there, 'the nodes {}'.format(NODES))

    def test_topics_and_types(self):
        wait_for(lambda: set(TOPICS) <= set(dict(self.master.getTopicTypes())), 'the topics')
        types = dict(self.master.getTopicTypes())
        self.assertEqual(TOPICS, {name: types[name] for name in TOPICS})

    def test_services(self):
        wait_for(lambda: SERVICES <= set(self._state()[2]), 'the services')

    def test_graph_is_the_articles(self):
        def arrows():
            publishers, subscribers, _ = self._state()
            return {(source, topic, sink) for topic in publishers
                    for source in publishers[topic] for sink in subscribers.get(topic, ())}
        wait_for(lambda: ARROWS <= arrows(), 'the arrows {}'.format(ARROWS))

    def test_tf_tree(self):
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        for frame in PARENTS:
            wait_for(lambda: buffer.can_transform('odom', frame, rospy.Time()), 'tf of ' + frame)
        frames = yaml.safe_load(buffer.all_frames_as_yaml())
        tree = {child: entry['parent'] for child, entry in frames.items()}
        self.assertEqual(PARENTS, tree)

    def test_every_node_reports_its_state(self):
        states = Diagnostics()
        found = states.values

        def counts(name, counter):
            return [int(values.get(counter, 0)) for values in found(name)]
        for name, counter in COUNTERS.items():
            wait_for(lambda: found(name) and counts(name, counter)[-1] > counts(name, counter)[0],
                     name + ' to count ' + counter)
        for name, key in (('color_extract: recognition', 'processing, max (ms)'),
                          ('color_extract: recognition', 'stamp to commands, max (ms)'),
                          ('usb_cam: camera', 'publishing a frame, max (ms)'),
                          ('gazebo: simulation', 'clock period, max (ms)')):
            def measured():
                # a period without an event has none
                return [values[key] for values in found(name) if values.get(key, 'none') != 'none']
            wait_for(measured, lambda: (name, key, found(name)))
            self.assertTrue(all(0 <= float(value) < 60000 for value in measured()),
                            (name, key, found(name)))
        states.close()

    def test_use_sim_time(self):
        self.assertIs(True, rospy.get_param('/use_sim_time'))


if __name__ == '__main__':
    main(NamesTest)
