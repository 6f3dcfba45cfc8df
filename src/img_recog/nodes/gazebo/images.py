"""All images of the node: of the cameras on robots, and of the view."""
import itertools
from typing import Dict, List, Sequence

import numpy as np
import rospy
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.errors import UserError
from img_recog.nodes.gazebo import camera_topics
from img_recog.nodes.gazebo.camera_topics import CameraTopics, RobotCameras, optical_transform
from img_recog.nodes.gazebo.drawing import Drawing
from img_recog.nodes.gazebo.names import Names
from img_recog.nodes.gazebo.static_transforms import StaticTransforms
from img_recog.nodes.gazebo.view import ViewTopic, camera_of
from img_recog.simulation.pictures import visual_scene
from img_recog.simulation.pictures.scene import Scene, scene_of
from img_recog.simulation.pictures.view import above
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors import robot_camera
from img_recog.simulation.settings import CameraSettings, ViewSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Reading, Vehicle


class Images:
    """Draws what the simulation looks like. All methods are for the thread that simulates."""

    def __init__(self, simulator: Simulator, view: ViewSettings, statics: StaticTransforms):
        self._simulator, self._statics = simulator, statics
        self._parts = Parts(simulator)
        self._view_camera = camera_of(view)
        self._drawing = Drawing(visual_scene.read(scene_of(simulator), self._parts),
                                self._parts.poses(), [self._view_camera])
        self._view = ViewTopic(view, self._drawing, 0, above(simulator.world))
        self._cameras = RobotCameras(self._drawing)
        self._seen: Dict[str, List[CameraSettings]] = {}    # by robot, with the names others see
        self._last_poses, self._last_poses_s = self._parts.poses(), -1.0

    def check_cameras(self, cameras: Sequence[CameraSettings], names: Names) -> None:
        """Raise a UserError if the topics of more cameras cannot be used."""
        camera_topics.check(itertools.chain(
            *self._seen.values(), (names.seen(each) for each in cameras)))

    def add_cameras(self, vehicle: Vehicle, cameras: Sequence[CameraSettings],
                    names: Names) -> None:
        """Mount cameras on a robot; publish where those are that its URDF does not have.

        Raises a UserError when the robot has no link for one, or their parameters cannot be used;
        nothing has changed then.
        """
        if not cameras:
            return
        seen = [names.seen(each) for each in cameras]
        sensors = [vehicle.mount_camera(each, self._poses) for each in cameras]
        try:
            for sensor, each in zip(sensors, seen):
                self._cameras.add(vehicle, sensor, CameraTopics(each, 0))
        except UserError:
            self._cameras.remove(vehicle)
            raise
        self._seen[vehicle.robot.name] = seen
        self._number_cameras()
        for each in cameras:
            warning = robot_camera.warning_about_frame(vehicle.robot, each)
            if warning:
                rospy.logwarn('%s', warning)
        self._statics.set('cameras of ' + vehicle.robot.name, [
            optical_transform(named) for each, named in zip(cameras, seen)
            if not vehicle.robot.has_frame(each.camera_optical_frame)])

    def remove_cameras(self, vehicle: Vehicle) -> None:
        """End the images of a robot's cameras."""
        if self._seen.pop(vehicle.robot.name, None):
            self._cameras.remove(vehicle)
            self._statics.remove('cameras of ' + vehicle.robot.name)
            self._number_cameras()

    def _number_cameras(self) -> None:
        topics = self._cameras.topics
        self._drawing.set_cameras([self._view_camera, *(each.camera for each in topics)])
        for number, each in enumerate(topics, 1):
            each.number = number

    def _poses(self) -> np.ndarray:
        """Return the poses of all parts, read once for all cameras that are read together."""
        time_s = self._simulator.time_s
        if self._last_poses_s != time_s:
            self._last_poses, self._last_poses_s = self._parts.poses(), time_s
        return self._last_poses

    def is_camera(self, reading: Reading) -> bool:
        """Return whether a reading is that of a camera."""
        return self._cameras.is_reading(reading)

    def set_scene(self, scene: Scene) -> None:
        """Show another scene from now on: something was added to the simulator or removed."""
        self._parts.refresh()
        self._drawing.set_scene(visual_scene.read(scene, self._parts), self._parts.poses())

    def enable_cameras(self) -> None:
        """Enable the cameras that are used; to be called before each simulated period."""
        self._last_poses_s = -1.0       # since then, anything may have been moved
        self._cameras.update()

    def draw(self, readings: Sequence[Reading]) -> None:
        """Draw what cameras among the sensors have read; waits for earlier images of them."""
        self._cameras.draw(readings)

    def update_view(self) -> None:
        """Draw the view, if it is time for an image of it and nothing else is drawn."""
        self._view.update(self._simulator, self._parts)

    def set_view(self, view: str) -> None:
        """Show the view from another viewpoint, one of VIEWS."""
        self._view.configure(view)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add to a status what was drawn; may be called in any thread."""
        self._drawing.report(status)

    def close(self) -> None:
        """End the process that draws."""
        self._drawing.close()
