"""Conversion of sensor_msgs/CameraInfo to and from calibrations."""
from typing import Optional

from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from img_recog.camera.calibration import Calibration


def to_msg(calibration: Optional[Calibration], width: int, height: int,
           header: Header) -> CameraInfo:
    """Return the message for images of width x height, in pixels.

    calibration: None for a camera that is not calibrated; then all matrices are zero, as
    sensor_msgs/CameraInfo defines.
    """
    msg = CameraInfo(header=header, width=width, height=height)
    if calibration is not None:
        msg.width, msg.height = calibration.width, calibration.height
        msg.distortion_model = calibration.distortion_model
        msg.D, msg.K = list(calibration.distortion), list(calibration.camera_matrix)
        msg.R, msg.P = list(calibration.rectification), list(calibration.projection)
    return msg


def from_msg(msg: CameraInfo, camera_name: str) -> Calibration:
    """Return the calibration in a message."""
    return Calibration(camera_name, msg.width, msg.height, msg.distortion_model, tuple(msg.D),
                       tuple(msg.K), tuple(msg.R), tuple(msg.P))
