"""All images of the node: of the cameras on the robot, and of the view."""
from typing import Sequence

import rospy
import tf2_ros
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.nodes.gazebo import camera_topics
from img_recog.nodes.gazebo.camera_topics import CameraTopics, RobotCameras, optical_transform
from img_recog.nodes.gazebo.drawing import Drawing
from img_recog.nodes.gazebo.view import ViewTopic, camera_of
from img_recog.simulation import robot_camera, visual_scene
from img_recog.simulation.scene import Scene
from img_recog.simulation.settings import CameraSettings, ViewSettings
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Reading, Vehicle
from img_recog.simulation.view import above
from img_recog.simulation.visual_scene import Parts


class Images:
    """Draws what the simulation looks like. All methods are for the thread that simulates."""

    def __init__(self, simulator: Simulator, scene: Scene, view: ViewSettings,
                 cameras: Sequence[CameraSettings]):
        """Mount the cameras on the robot; publish where those are that its URDF does not have.

        scene: that of the simulator. Raises a UserError when the robot has no link for one, or
        their topics cannot be used.
        """
        camera_topics.check(cameras)
        self._simulator = simulator
        self._parts = Parts(simulator)
        topics = [CameraTopics(each, number) for number, each in enumerate(cameras, 1)]
        self._drawing = Drawing(visual_scene.read(scene, self._parts), self._parts.poses(),
                                [camera_of(view), *(each.camera for each in topics)])
        self._view = ViewTopic(view, self._drawing, 0, above(simulator.world))
        vehicle = simulator.vehicles[0]
        names = [vehicle.mount_camera(each, self._parts.poses) for each in cameras]
        self._cameras = RobotCameras(vehicle, names, topics, self._drawing)
        self._publish_frames(vehicle, cameras)

    def _publish_frames(self, vehicle: Vehicle, cameras: Sequence[CameraSettings]) -> None:
        for each in cameras:
            warning = robot_camera.warning_about_frame(vehicle.robot, each)
            if warning:
                rospy.logwarn('%s', warning)
        unknown = [optical_transform(each) for each in cameras
                   if not vehicle.robot.has_frame(each.camera_optical_frame)]
        if unknown:
            self._static_transforms = tf2_ros.StaticTransformBroadcaster()
            self._static_transforms.sendTransform(unknown)

    def is_camera(self, sensor: str) -> bool:
        """Return whether a sensor is one of the cameras."""
        return sensor in self._cameras

    def set_scene(self, scene: Scene) -> None:
        """Show another scene from now on: something was added to the simulator or removed."""
        self._parts.refresh()
        self._drawing.set_scene(visual_scene.read(scene, self._parts), self._parts.poses())

    def enable_cameras(self) -> None:
        """Enable the cameras that are used; to be called before each simulated period."""
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
