"""The frames of a camera on the simulated robot: what it sees depends on the commands before."""
import logging
from typing import Any, Callable, Iterator

import genpy
from std_msgs.msg import Header

from img_recog.conversions.robot_cameras import DrawnCamera, Drawing
from img_recog.recordings.camera_infos import CameraInfos, of_calibration
from img_recog.recordings.frames import SECOND_NS, Frame, Frames
from img_recog.rendering.light import LightFilter, LightSettings
from img_recog.settings import nearest_period
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog.simulation.simulator import Simulator

_log = logging.getLogger(__name__)


class RobotFrames(Frames):
    """Draws a frame in each period of the camera, when the simulation has come to its time.

    expected: the number of frames; period_ns: time between two frames.
    """

    def __init__(self, simulator: Simulator, settings: CameraSettings, seconds: float,
                 light: LightSettings = LightSettings(), noise_seed: int = 0,
                 drawn_by: Any = None):
        """Load the scene; UserError when it cannot be drawn or the robot has no such link.

        light: in which all is seen. noise_seed: makes the noise another one. drawn_by: a renderer
        that nothing else uses meanwhile, by default a new one.
        """
        super().__init__(settings.camera_frame)
        self._camera, self._drawing = DrawnCamera(settings), Drawing(simulator, drawn_by)
        robot, = simulator.robots
        self._sensor = RobotCamera(robot.body, settings, self._drawing.poses)
        self._noise_seed = noise_seed
        self._light = None if light == LightSettings() else LightFilter(light)
        self._frame_id = settings.camera_optical_frame
        step_s = simulator.world.step_s
        self.period_ns = round(nearest_period(settings.camera_rate, step_s) * SECOND_NS)
        self.expected = max(1, round(seconds * SECOND_NS / self.period_ns))
        for reason in self._drawing.missing:
            _log.warning('not drawn: %s', reason)
        self._simulate_until: Callable[[int], None] = lambda time_ns: None

    def follow(self, simulate_until: Callable[[int], None]) -> None:
        """Set the function that simulates until a time in ns; to be called before iterating."""
        self._simulate_until = simulate_until

    def camera_infos(self) -> CameraInfos:
        """Return those of the camera."""
        return of_calibration(self._camera.calibration)

    def read(self) -> Iterator[Frame]:
        """Yield all frames."""
        for number in range(self.expected):
            stamp_ns = number * self.period_ns
            self._simulate_until(stamp_ns)
            image = self._drawing.image(self._camera, self._sensor.read(),
                                        self._noise_seed + number, self._light)
            self.note(used=1)
            header = Header(seq=number, stamp=genpy.Time(nsecs=stamp_ns), frame_id=self._frame_id)
            yield Frame(number, stamp_ns, header, image, 'rgb8')
