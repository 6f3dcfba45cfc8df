"""Sets the V4L2 controls of the camera from parameters."""
import dataclasses
import threading
from typing import Callable, Mapping, Optional, Set

import rospy

from img_recog.camera import controls
from img_recog.camera.controls import ControlDevice
from img_recog.camera.usb_cam_settings import ControlSettings
from img_recog.errors import one_line
from img_recog.settings import setting_fields


class CameraControls:
    """Sets the controls of a device each time it is opened, and each time they change."""

    def __init__(self, settings: ControlSettings, intrinsic: Mapping[str, int]):
        self._settings, self._intrinsic = settings, intrinsic
        self._path: Optional[str] = None
        self._lock = threading.Lock()
        self._logged: Set[str] = set()

    def set_device(self, path: Optional[str]) -> None:
        """Set the controls of the device at `path`, which was opened; None: it is not a device."""
        with self._lock:
            self._path = path
            if path is None:
                self._log_without_effect()
            self._apply(self._intrinsic)

    def change(self, settings: ControlSettings) -> None:
        """Apply new settings, now and each time the device is opened again."""
        with self._lock:
            changed = [field.name for field in dataclasses.fields(settings)
                       if getattr(settings, field.name) != getattr(self._settings, field.name)]
            self._settings = settings
            self._logged = {problem for problem in self._logged
                            if not any(name in problem for name in changed)}
            self._apply({})

    def _apply(self, intrinsic: Mapping[str, int]) -> None:
        if self._path is None:
            return
        try:
            device = ControlDevice(self._path)
        except OSError as error:
            self._warn('cannot set the controls of {}: {}'.format(self._path, one_line(error)))
            return
        try:
            for problem in controls.apply(device, self._settings, intrinsic):
                self._warn(problem)
        finally:
            device.close()

    def _log_without_effect(self) -> None:
        given = [field.name for field in setting_fields(ControlSettings)
                 if getattr(self._settings, field.name) != field.default]
        if given or self._intrinsic:
            self._log_once(rospy.loginfo, 'not a device: these controls have no effect: {}'.format(
                ', '.join(given + sorted(self._intrinsic))))

    def _warn(self, problem: str) -> None:
        self._log_once(rospy.logwarn, problem)

    def _log_once(self, log: Callable[..., None], line: str) -> None:
        if line not in self._logged:       # not again each time the device is reopened
            self._logged.add(line)
            log('%s', line)
