"""The sensor_msgs/CameraInfo of each frame of an input."""
import bisect
import copy
from typing import Any, Callable, Iterable, List, Optional, Tuple

from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from img_recog.camera.calibration import Calibration, scaled
from img_recog.conversions import image_msgs
from img_recog.recordings.frames import Frame

# returns a new message for a frame; raises UserError if none fits to it
CameraInfos = Callable[[Frame], CameraInfo]


def of_calibration(calibration: Optional[Calibration]) -> CameraInfos:
    """Return those of a camera; calibration: None if it is not calibrated."""
    def camera_info(frame: Frame) -> CameraInfo:
        height, width = frame.image.shape[:2]
        fitting = calibration and scaled(calibration, width, height)
        return image_msgs.info_to_msg(fitting, width, height, frame.header)
    return camera_info


def recorded(messages: Iterable[Tuple[str, CameraInfo, Any, Any]]) -> CameraInfos:
    """Return those of a bag: the last one that is not newer than the frame, or else the first.

    messages: of one topic, as of BagFile. Without any, the camera is not calibrated.
    """
    infos: List[Tuple[int, CameraInfo]] = []
    last = None
    for _, msg, time, _ in messages:
        plain = copy.copy(msg)
        plain.header = Header()
        if plain != last:       # of a long recording, few are different
            infos.append(((msg.header.stamp or time).to_nsec(), msg))
            last = plain
    if not infos:
        return of_calibration(None)
    infos.sort(key=lambda info: info[0])
    stamps_ns = [stamp_ns for stamp_ns, _ in infos]

    def camera_info(frame: Frame) -> CameraInfo:
        number = max(0, bisect.bisect_right(stamps_ns, frame.stamp_ns) - 1)
        return copy.deepcopy(infos[number][1])
    return camera_info
