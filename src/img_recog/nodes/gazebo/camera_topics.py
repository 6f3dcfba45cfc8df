"""The topics of the cameras on a simulated robot."""
import threading
import zlib
from functools import partial
from typing import Any, Optional, Set

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import CameraInfo, PointCloud2
from std_msgs.msg import Header

from img_recog import rotations
from img_recog.conversions import image_msgs, robot_cameras, robot_msgs
from img_recog.conversions.robot_cameras import DrawnCamera
from img_recog.nodes.compressed_images import CompressedImages, publisher
from img_recog.rendering import lens_views
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Picture, Shot
from img_recog.ros.transport.image_publisher import ImagePublisher, LargePublisher
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.simulation.sensors.robot_camera import Exposure, optical_frame
from img_recog.simulation.simulation_settings import CameraSettings

_FROM_RGB = {'bgr8': cv2.COLOR_RGB2BGR, 'mono8': cv2.COLOR_RGB2GRAY}
_INFO_QUEUE_SIZE = 10       # so that each image has its camera info, also if a sender has to wait


class CameraTopics:
    """Publishes the images of one camera, and what is true about them.

    Topics, all with the same header: images (sensor_msgs/Image), the same compressed, as a
    Gazebo with compressed_image_transport publishes them, and a sensor_msgs/CameraInfo. Of a depth
    camera also depths (sensor_msgs/Image, 32FC1 in m or 16UC1 in mm), with a
    sensor_msgs/CameraInfo, and their points with colors (sensor_msgs/PointCloud2).
    """

    def __init__(self, settings: CameraSettings, redelivery: Optional[Redelivery] = None):
        """Advertise the topics; settings: with the names that others see.

        redelivery: sends the images.
        """
        self.settings = settings
        self._lock, self._is_closed = threading.Lock(), False
        self._is_kept = redelivery is not None
        self._used: Set[Any] = set()        # the publishers that had a subscriber
        self._used_lock = threading.Lock()  # of _used: the loop and the thread that publishes
        self._drawn = DrawnCamera(settings)
        # so that the noise of two cameras is not the same
        self._own_number = zlib.crc32(settings.camera_image_topic.encode())
        self._compressed = CompressedImages(settings.camera_image_topic, redelivery)
        self._images = ImagePublisher(settings.camera_image_topic, redelivery)
        self._infos = [publisher(settings.camera_info_topic, CameraInfo, _INFO_QUEUE_SIZE,
                                 redelivery)]
        self._depths = self._points = None
        if settings.camera_depth_topic:
            self._depths = ImagePublisher(settings.camera_depth_topic, redelivery)
            self._infos.append(publisher(settings.camera_depth_info_topic, CameraInfo,
                                         _INFO_QUEUE_SIZE, redelivery))
        if settings.camera_points_topic:
            self._points = LargePublisher(settings.camera_points_topic, PointCloud2, redelivery)
        if self._drawn.calibration is None:
            rospy.logwarn('the camera info on %s has no calibration: no distortion model can say '
                          'what its lens does', settings.camera_info_topic)

    def is_wanted(self) -> bool:
        """Return whether a topic has a subscriber, or had one that may come back."""
        return self._compressed.is_wanted() or self._is_used(
            self._images, self._depths, self._points, *self._infos)

    def _is_used(self, *publishers: Any) -> bool:
        with self._used_lock:
            used = {each for each in publishers if each is not None and (
                each in self._used or each.get_num_connections() > 0)}
            if self._is_kept:
                self._used |= used
        return bool(used)

    def shot(self, exposure: Exposure) -> Shot:
        """Return what is to be drawn of an exposure."""
        return self._drawn.shot(exposure, self._is_used(self._depths, self._points))

    @property
    def camera(self) -> Camera:
        """What draws it."""
        return self._drawn.camera

    def publish(self, picture: Picture, time_s: float) -> None:
        """Publish what was drawn of the exposure at a simulated time; may change the image."""
        with self._lock:        # the robot may be removed while its image is drawn
            if not self._is_closed:
                self._publish(*picture, time_s)

    def _publish(self, image: np.ndarray, depth: Optional[np.ndarray], time_s: float) -> None:
        header = Header(stamp=robot_msgs.stamp_of(time_s),
                        frame_id=self.settings.camera_optical_frame)
        self._drawn.add_noise(image, round(time_s * 1e6) + self._own_number)
        encoding = self.settings.camera_encoding
        shown = cv2.cvtColor(image, _FROM_RGB[encoding]) if encoding in _FROM_RGB else image
        self._images.publish(shown, encoding, header)
        if self._compressed.is_wanted():
            # it is compressed later, when what is drawn may not be valid any more
            self._compressed.publish(shown.copy(), encoding, header)
        if depth is not None:
            self._publish_depths(depth, image, header)
        info = self.info(header)
        for each in self._infos:
            each.publish(info)

    def _publish_depths(self, depth: np.ndarray, image: np.ndarray, header: Header) -> None:
        settings = self.settings
        depth = robot_cameras.within(
            depth, (settings.camera_points_min, settings.camera_points_max))
        if self._depths is not None:
            encoding = settings.camera_depth_encoding
            self._depths.publish(robot_cameras.depths_to_bytes(depth, encoding), encoding, header)
        if self._points is not None and self._is_used(self._points):
            self._points.publish_data(
                partial(robot_cameras.draw_points, depths=depth, image=image,
                        slopes=lens_views.slopes(self.camera)),
                (*depth.shape, robot_cameras.POINT_BYTES),
                robot_cameras.cloud_without_points(depth, header))

    def info(self, header: Header) -> CameraInfo:
        """Return the intrinsic parameters; all are zero if no model can say what the lens does."""
        return image_msgs.info_to_msg(self._drawn.calibration, self.camera.width,
                                      self.camera.height, header)

    def close(self) -> None:
        """End the topics."""
        with self._lock:
            self._is_closed = True
        self._compressed.close()
        for each in (self._images, self._depths, self._points, *self._infos):
            if each is not None:
                each.unregister()


def optical_transform(settings: CameraSettings) -> TransformStamped:
    """Return the pose of the optical frame in the link of the camera, for /tf_static."""
    optical = optical_frame(settings)
    transform = TransformStamped(child_frame_id=settings.camera_optical_frame)
    transform.header.frame_id = settings.camera_frame
    transform.transform.translation = Vector3(*optical.translation)
    transform.transform.rotation = Quaternion(*rotations.quaternion_of(optical.rotation))
    return transform
