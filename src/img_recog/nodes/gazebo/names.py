"""What the topics and frames of a robot are called."""
import dataclasses
from typing import NamedTuple

from img_recog.simulation.settings import CameraSettings

CAMERA_TOPICS = ('camera_image_topic', 'camera_info_topic', 'camera_depth_topic',
                 'camera_depth_info_topic')
_CAMERA_FRAMES = ('camera_frame', 'camera_optical_frame')


class Names(NamedTuple):
    """The namespace of the topics of a robot, and the prefix of its frames, both without slashes
    at the ends; '' for none.
    """

    namespace: str = ''
    frame_prefix: str = ''

    @property
    def words(self) -> str:
        """The robot in a sentence."""
        return 'robot ' + self.namespace if self.namespace else 'the robot'

    def topic(self, name: str) -> str:
        """Return the topic in the namespace, unless its name is global."""
        return '/'.join((self.namespace, name)) if self._is_relative(name) else name

    def frame(self, name: str) -> str:
        """Return the frame with the prefix, like tf::resolve."""
        return '/'.join((self.frame_prefix, name)) if self.frame_prefix else name

    def camera(self, settings: CameraSettings) -> CameraSettings:
        """Return the settings with the names of topics and frames that others see."""
        topics = {field: self.topic(getattr(settings, field)) for field in CAMERA_TOPICS
                  if getattr(settings, field)}
        frames = {field: self.frame(getattr(settings, field)) for field in _CAMERA_FRAMES}
        return dataclasses.replace(settings, **topics, **frames)

    def _is_relative(self, name: str) -> bool:
        return bool(self.namespace) and not name.startswith('/')
