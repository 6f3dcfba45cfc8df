"""The sensors of a simulated robot: a row each.

The simulator's tags, settings, noise and readings, the topics of the node, the replay and the test
of the documentation go by this table. The images of cameras are drawn by another process.
"""
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu, JointState, LaserScan, Range

from img_recog.conversions import robot_msgs
from img_recog.simulation.sensors import (contact_sensor, imu, joint_states, laser_scanner,
                                          odometry, range_sensor, robot_camera)
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulation_settings import CameraSettings

CAMERA = SensorKind(robot_camera.CAMERA, CameraSettings, robot_camera.make, robot_camera.TAGS,
                    Image, None, noise_number=7, only_in_tags=True)
# sensors are read, and their readings published, in this order
SENSORS = (
    SensorKind('odometry', odometry.OdometrySettings, odometry.make_odometry, odometry.TAGS,
               Odometry, robot_msgs.odometry_to_msg, noise_number=2),
    SensorKind('joint_states', joint_states.JointStateSettings, joint_states.JointStateSensor,
               joint_states.TAGS, JointState, robot_msgs.joint_states_to_msg, noise_number=3),
    SensorKind('imu', imu.ImuSettings, imu.Imu, imu.TAGS, Imu, robot_msgs.imu_to_msg,
               noise_number=1),
    SensorKind('scan', laser_scanner.ScanSettings, laser_scanner.LaserScanner,
               laser_scanner.TAGS, LaserScan, robot_msgs.scan_to_msg, noise_number=0),
    SensorKind('range', range_sensor.RangeSettings, range_sensor.RangeSensor, range_sensor.TAGS,
               Range, robot_msgs.range_to_msg, noise_number=5, only_in_tags=True),
    SensorKind('contact', contact_sensor.ContactSettings, contact_sensor.ContactSensor,
               contact_sensor.TAGS, robot_msgs.ContactsState, robot_msgs.contacts_to_msg,
               noise_number=6, only_in_tags=True, missing=robot_msgs.NO_CONTACTS),
    CAMERA,
)
