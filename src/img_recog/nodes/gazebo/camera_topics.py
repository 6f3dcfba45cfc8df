"""The topics of the cameras on a simulated robot."""
import threading
from typing import Dict, Iterable, Optional

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from img_recog import rotations
from img_recog.conversions import robot_msgs
from img_recog.errors import UserError
from img_recog.nodes.compressed_images import CompressedImages
from img_recog.nodes.gazebo.names import topic_fields
from img_recog.rendering.camera import Camera
from img_recog.rendering.noise import PixelNoise
from img_recog.rendering.server import Picture, Shot
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.settings import SettingError
from img_recog.simulation.sensors.robot_camera import Exposure, optical_frame
from img_recog.simulation.settings import CameraSettings

_INFO_QUEUE_SIZE = 10       # so that each image has its camera info, also if a sender has to wait


def check(cameras: Iterable[CameraSettings]) -> None:
    """Raise a UserError if a topic of the cameras has no valid name, or is that of two."""
    owners: Dict[str, str] = {}
    for camera in cameras:
        for setting in topic_fields(camera):
            topic = getattr(camera, setting)
            if not rosgraph.names.is_legal_name(topic):
                raise SettingError(setting, topic, 'a valid topic name')
            owner = '{} of the camera on {}'.format(setting, camera.camera_frame)
            other = owners.setdefault(rospy.resolve_name(topic), owner)
            if other is not owner:
                raise UserError('the topic {} is {} and {}'.format(topic, other, owner),
                                'give each camera other topics: in a <gazebo> tag, another '
                                '<cameraName>; as parameters, another ' + setting)


class CameraTopics:
    """Publishes the images of one camera, and what is true about them.

    Topics, all with the same header: images (sensor_msgs/Image, rgb8), the same compressed, as a
    Gazebo with compressed_image_transport publishes them, depths (sensor_msgs/Image, 32FC1, m;
    only of a depth camera), and for images and depths a sensor_msgs/CameraInfo each.
    """

    def __init__(self, settings: CameraSettings):
        """Advertise the topics; settings: with the names that others see."""
        self.settings = settings
        self._lock, self._is_closed = threading.Lock(), False
        self.camera = Camera(settings.camera_width, settings.camera_height,
                             settings.camera_horizontal_fov, settings.camera_near,
                             settings.camera_far)
        self._noise = PixelNoise(settings.camera_noise) if settings.camera_noise else None
        # first: it fails if its parameters are wrong
        self._compressed = CompressedImages(settings.camera_image_topic)
        self._images = ImagePublisher(settings.camera_image_topic)
        self._infos = [rospy.Publisher(settings.camera_info_topic, CameraInfo,
                                       queue_size=_INFO_QUEUE_SIZE)]
        self._depths = None
        if settings.camera_depth_topic:
            self._depths = ImagePublisher(settings.camera_depth_topic)
            self._infos.append(rospy.Publisher(settings.camera_depth_info_topic, CameraInfo,
                                               queue_size=_INFO_QUEUE_SIZE))

    def is_wanted(self) -> bool:
        """Return whether any of the topics has a subscriber."""
        return (self._images.get_num_connections() > 0 or self._compressed.is_wanted()
                or self._wants_depth()
                or any(publisher.get_num_connections() > 0 for publisher in self._infos))

    def _wants_depth(self) -> bool:
        return self._depths is not None and self._depths.get_num_connections() > 0

    def shot(self, exposure: Exposure) -> Shot:
        """Return what is to be drawn of an exposure."""
        return Shot(self.camera, exposure.camera_pose, self._wants_depth())

    def publish(self, picture: Picture, time_s: float) -> None:
        """Publish what was drawn of the exposure at a simulated time; may change the image."""
        with self._lock:        # the robot may be removed while its image is drawn
            if not self._is_closed:
                self._publish(*picture, time_s)

    def _publish(self, image: np.ndarray, depth: Optional[np.ndarray], time_s: float) -> None:
        header = Header(stamp=robot_msgs.stamp_of(time_s),
                        frame_id=self.settings.camera_optical_frame)
        if self._noise is not None:
            self._noise.add(image, round(time_s * 1e6))
        self._images.publish(image, 'rgb8', header)
        if self._compressed.is_wanted():
            # it is compressed later, when what is drawn may not be valid any more
            self._compressed.publish(image.copy(), 'rgb8', header)
        if self._depths is not None and depth is not None:
            as_bytes = depth.view(np.uint8).reshape(*depth.shape, 4)
            self._depths.publish(as_bytes, '32FC1', header)
        info = self.info(header)
        for publisher in self._infos:
            publisher.publish(info)

    def info(self, header: Header) -> CameraInfo:
        """Return the intrinsic parameters: a camera without distortion."""
        fx, fy, cx, cy = self.camera.intrinsics
        return CameraInfo(
            header=header, width=self.camera.width, height=self.camera.height,
            distortion_model='plumb_bob', D=[0.0] * 5,
            K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0])

    def close(self) -> None:
        """End the topics."""
        with self._lock:
            self._is_closed = True
        self._images.unregister()
        self._compressed.close()
        if self._depths is not None:
            self._depths.unregister()
        for publisher in self._infos:
            publisher.unregister()


def optical_transform(settings: CameraSettings) -> TransformStamped:
    """Return the pose of the optical frame in the link of the camera, for /tf_static."""
    optical = optical_frame(settings)
    transform = TransformStamped(child_frame_id=settings.camera_optical_frame)
    transform.header.frame_id = settings.camera_frame
    transform.transform.translation = Vector3(*optical.translation)
    transform.transform.rotation = Quaternion(*rotations.quaternion_of(optical.rotation))
    return transform
