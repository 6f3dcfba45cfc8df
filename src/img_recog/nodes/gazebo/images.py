"""All images of the node: of the cameras on robots, of the view, and of the window."""
import dataclasses
import itertools
import math
import threading
import time
from typing import Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from std_msgs.msg import Header

from img_recog.conversions import robot_msgs
from img_recog.errors import UserError
from img_recog.nodes.gazebo.camera_topics import CameraTopics, optical_transform
from img_recog.nodes.gazebo.image_process import ImageProcess
from img_recog.nodes.gazebo.time_gate import TimeGate, Wait
from img_recog.nodes.gazebo.transforms import StaticTransforms
from img_recog.rendering.camera import Camera
from img_recog.rendering.server import Picture, Shot
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.simulation.pictures.view import (above, ceiling, follow, horizontal_fov,
                                                near_and_far)
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.pictures.window import Window, poses_of, scene_of
from img_recog.simulation.sensors import robot_camera
from img_recog.simulation.simulated_model import MountedSensors, Reading
from img_recog.simulation.simulation_settings import CameraSettings, ViewSettings
from img_recog.simulation.simulator import Simulator

# Where OpenGL runs on the processor, the physics comes first; in lockstep, it waits.
_NICENESS = 5
_POLL_PERIOD_S = 0.1
_VIEW_FRAME = 'view'            # not a frame of tf: the camera is not part of the robot


class ViewTopic:
    """Publishes ~view/image_raw (sensor_msgs/Image, rgb8) while it has a subscriber."""

    def __init__(self, settings: ViewSettings, simulator: Simulator):
        """Advertise the topic."""
        self._settings, self._simulator = settings, simulator
        self._above = above(simulator.world)
        width, height = settings.view_width, settings.view_height
        self.camera = Camera(width, height, horizontal_fov(width, height))
        self._images = ImagePublisher('~view/image_raw')
        self._next_s = 0.0

    def configure(self, view: str) -> None:
        """Show the simulation from another viewpoint, one of VIEWS, from now on."""
        self._settings = dataclasses.replace(self._settings, view=view)
        self._next_s = 0.0

    def is_wanted(self) -> bool:
        """Return whether the topic has a subscriber."""
        return self._images.get_num_connections() > 0

    def take_due(self) -> bool:
        """Return whether it is time for an image: once in each period of wall time."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return False
        self._next_s = now_s + 1 / self._settings.view_rate
        return True

    def shot(self) -> Shot:
        """Return what is to be drawn now."""
        viewpoint, robots = self._above, self._simulator.robots
        if self._settings.view == 'follow' and robots:
            viewpoint = follow(robots[0].body.pose())
        pose = viewpoint.pose()
        edges = self.camera.edges
        near, far = near_and_far(pose, (edges.right, edges.top))
        roof = ceiling(self._simulator.world, [each.body for each in robots])
        return Shot(self.camera._replace(near=near, far=far), pose,
                    ceiling=roof if roof < pose[2, 3] else math.inf)

    def publish(self, picture: Picture, time_s: float) -> None:
        """Publish what was drawn at a simulated time."""
        header = Header(stamp=robot_msgs.stamp_of(time_s), frame_id=_VIEW_FRAME)
        self._images.publish(picture[0], 'rgb8', header)


class Images:
    """Draws what the simulation looks like. All methods are for the thread that simulates.

    It tells the gate of simulated time which images are not drawn yet, in lockstep, and whether
    the world is loaded.

    A camera is used while one of its topics has a subscriber. At most one image of the view is
    drawn in each period of wall time, with the next one of a camera if there are such: the
    simulation does not wait for it.
    """

    def __init__(self, simulator: Simulator, view: ViewSettings, statics: StaticTransforms,
                 gate: TimeGate, wake: Callable[[], None],
                 redelivery: Optional[Redelivery] = None):
        """Start nothing yet.

        Args:
            simulator: Simulator.
            view: Settings of the view and the window.
            statics: Publisher of the frames of cameras.
            gate: Gate of simulated time.
            wake: Function that is called after images of cameras were published.
            redelivery: Sends the images in lockstep; a camera that was used once then stays in
                use.
        """
        self._simulator, self._statics, self._redelivery = simulator, statics, redelivery
        self._gate, self._wake = gate, wake
        self._skips = view.skip_images and redelivery is None
        self._revision = simulator.world.revision
        self._parts = Parts(simulator)
        self._view = ViewTopic(view, simulator)
        self._window: Optional[Window] = (
            Window(scene_of(simulator), above(simulator.world)) if view.gui else None)
        self._process = ImageProcess(self._parts.scene(), self._parts.poses(), [self._view.camera],
                                     _NICENESS if redelivery is None else 0)
        # by the names of robot and sensor
        self._cameras: Dict[Tuple[str, str], Tuple[MountedSensors, CameraTopics]] = {}
        self._last_poses, self._last_poses_s = self._parts.poses(), -1.0
        self._is_view_due = False
        self._exposures = 0         # how often cameras have read; those that are read together
        self._published = 0         # the last of these, under the lock of _publication
        self._publication = threading.Condition()

    def add_cameras(self, mounted: MountedSensors) -> None:
        """Draw the cameras of a model; publish where those are that its URDF does not have.

        Raises a UserError when their parameters cannot be used; nothing has changed then.
        """
        if not mounted.cameras:
            return
        cameras = [camera.settings for camera in mounted.cameras.values()]
        seen = [mounted.spec.names.seen(each) for each in cameras]
        try:
            for (sensor, camera), each in zip(mounted.cameras.items(), seen):
                camera.poses = self._poses
                self._cameras[mounted.body.name, sensor] = mounted, CameraTopics(
                    each, self._redelivery)
        except UserError:
            self.remove_cameras(mounted)
            raise
        self._process.set_cameras([self._view.camera, *(
            topics.camera for _, topics in self._cameras.values())])
        for each in cameras:
            warning = robot_camera.warning_about_frame(mounted.body, each)
            if warning:
                rospy.logwarn('%s', warning)
        frames: Dict[str, CameraSettings] = {}
        for each, named in zip(cameras, seen):
            if not mounted.body.has_frame(each.camera_optical_frame):
                # of a stereo pair, both images have the frame of the left one
                frames.setdefault(named.camera_optical_frame, named)
        self._statics.set('cameras of ' + mounted.body.name,
                          [optical_transform(named) for named in frames.values()])

    def remove_cameras(self, mounted: MountedSensors) -> None:
        """End the images of the cameras of a model."""
        for key, (owner, topics) in list(self._cameras.items()):
            if owner is mounted:
                topics.close()
                del self._cameras[key]
        self._statics.remove('cameras of ' + mounted.body.name)

    def _poses(self) -> np.ndarray:
        """Return the poses of all parts, read once for all cameras that are read together."""
        time_s = self._simulator.time_s
        if self._last_poses_s != time_s:
            self._last_poses, self._last_poses_s = self._parts.poses(), time_s
        return self._last_poses

    def is_camera(self, reading: Reading) -> bool:
        """Return whether a reading is that of a camera."""
        return (reading.robot, reading.sensor) in self._cameras

    def update_scene(self) -> bool:
        """Show what was added to the simulator, removed or rearranged; return whether it was."""
        if self._revision == self._simulator.world.revision:
            return False
        self._revision = self._simulator.world.revision
        self._parts.refresh()
        self._process.set_scene(self._parts.scene(), self._parts.poses())
        if self._window is not None:
            self._window.set_scene(scene_of(self._simulator))
        return True

    def enable_cameras(self) -> None:
        """Enable the cameras that are used; to be called before each simulated period."""
        self._last_poses_s = -1.0       # since then, anything may have been moved
        for (_, sensor), (mounted, topics) in self._cameras.items():
            is_wanted = topics.is_wanted()
            if is_wanted:
                self._process.start()
            mounted.set_enabled(sensor, is_wanted and self._process.is_ready)

    def look(self) -> None:
        """Tell the gate whether the world is loaded, and of images that can never be drawn."""
        if not self._gate.holds(Wait.LOADING):
            return      # the process is started when an image is wanted
        self._gate.expect(Wait.LOADING, ['the world'] if self._is_loading() else ())
        unpublished = self._gate.awaited(Wait.IMAGES)
        if unpublished and self._cannot_draw():
            self._gate.end(Wait.IMAGES, *unpublished)

    def _is_loading(self) -> bool:
        """Return whether a camera that is mounted or used cannot be drawn yet; starts to load."""
        if not self._cameras:
            return False
        self._process.start()
        return self._process.is_loading

    def is_complete(self) -> bool:
        """Return whether all images of cameras that can be drawn are published.

        Those that were lost with the process are drawn again.
        """
        with self._publication:
            is_published = self._published == self._exposures
        return is_published or self._cannot_draw()

    def wait_complete(self) -> None:
        """Wait until `is_complete`, or a shutdown.

        An image can be answered while the thread that publishes it has not ended yet: it may wait
        for the processor that the answering node uses.
        """
        while not self.is_complete() and not rospy.is_shutdown():
            with self._publication:
                self._publication.wait_for(
                    lambda: self._published == self._exposures, _POLL_PERIOD_S)

    def _cannot_draw(self) -> bool:
        if self._process.has_lost and not self._is_loading():
            self._process.draw_again()
        return not (self._process.is_ready or self._process.is_loading)

    def draw(self, readings: Sequence[Reading], publish_others: Callable[[], None]) -> None:
        """Draw what cameras among the sensors have read; waits for earlier images of them, or
        with skip_images, draws nothing meanwhile.

        publish_others: publishes the other readings, which are published before the images.
        """
        exposures = [list(same_time) for _, same_time in itertools.groupby(
            filter(self.is_camera, readings), key=lambda each: each.time_s)]
        if len(exposures) == 1:
            # of this one alone: an earlier one may be published while this one waits for it
            others_are_published = threading.Event()
            try:
                self._draw(exposures[0], others_are_published)
                publish_others()        # while the images are drawn
            finally:
                others_are_published.set()
        else:
            publish_others()
            for exposed in exposures:
                self._draw(exposed)

    def update_view(self) -> None:
        """Draw the view, if it is time for an image of it and nothing else is drawn."""
        if not self._view.is_wanted():
            return
        self._process.start()
        if self._process.is_ready and self._view.take_due():
            self._is_view_due = True
            if self.is_complete() and not self._process.is_busy:
                self._draw([])

    def update_window(self) -> None:
        """Send the poses to the window, if there is one and it needs new ones."""
        if self._window is None or not self._window.due():
            return
        reason = self._window.show(poses_of(self._simulator))
        if reason is not None:
            rospy.logwarn('no window: %s; the simulation goes on without it', reason)
            self._window = None

    def _draw(self, readings: Sequence[Reading],
              others_are_published: Optional[threading.Event] = None) -> None:
        """Draw what cameras have read at one time, or nothing, with the view if it is due."""
        time_s = readings[0].time_s if readings else self._simulator.time_s
        if readings:
            if self._skips and self._process.is_busy:
                return
            self._exposures += 1
            self._gate.expect(Wait.IMAGES, [self._exposures])
        exposure = self._exposures
        cameras = [self._cameras[each.robot, each.sensor][1] for each in readings]
        publishers: List[Union[CameraTopics, ViewTopic]] = list(cameras)
        shots = [camera.shot(each.value) for camera, each in zip(cameras, readings)]
        if self._is_view_due:
            self._is_view_due = False
            publishers.append(self._view)
            shots.append(self._view.shot())

        def publish(pictures: Sequence[Picture]) -> None:
            if others_are_published is not None:
                others_are_published.wait()
            if readings:
                self._gate.notify_sent()
                self._gate.end(Wait.IMAGES, exposure)
            for each, picture in zip(publishers, pictures):
                each.publish(picture, time_s)
            if readings:
                with self._publication:
                    self._published = exposure
                    self._publication.notify()
                self._wake()
        self._process.draw(
            shots, readings[0].value.poses if readings else self._parts.poses(), publish)

    def set_view(self, view: str) -> None:
        """Show the view from another viewpoint, one of VIEWS."""
        self._view.configure(view)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add to a status what was drawn; may be called in any thread."""
        self._process.report(status)

    def close(self) -> None:
        """End the process that draws, and the window."""
        self._process.close()
        if self._window is not None:
            self._window.close()
