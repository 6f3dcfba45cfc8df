"""The node web: a page that shows the running system and drives the robot.

Publishes: cmd_vel (geometry_msgs/Twist, 20 Hz of wall time while a visitor drives, then zeros),
gazebo/set_pose (geometry_msgs/PoseStamped), /diagnostics (diagnostic_msgs/DiagnosticArray, 1 Hz).
Subscribes, while somebody looks at a page: usb_cam/image_raw (sensor_msgs/Image) and other images,
odom (nav_msgs/Odometry), scan (sensor_msgs/LaserScan), color_detection (sensor_msgs/PointCloud),
gazebo/real_time_factor (std_msgs/Float64), gazebo/world_outlines (visualization_msgs/MarkerArray),
/rosout_agg (rosgraph_msgs/Log), and the topics that it publishes.
Calls the services of gazebo that pause and reset, the service ~yield of the other publishers of
cmd_vel, and dynamic_reconfigure of color_extract and gazebo.
Reads: ~web_host, ~web_port (WebSettings), ~max_linear_velocity, ~max_angular_velocity
(TeleopSettings).
"""
import contextlib
import itertools
import os
import secrets
import sys
import threading
import time
import traceback
from typing import Dict, List, Optional, Set, Tuple

import cv2
import numpy as np
import rosgraph
import rospy
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from fastapi import FastAPI, WebSocket, WebSocketDisconnect

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.graph import dot
from img_recog.graph.reader import SystemReader
from img_recog.graph.system import Choice, visible
from img_recog.nodes.web import page
from img_recog.nodes.web.doors import Doors
from img_recog.nodes.web.driving import Driving
from img_recog.nodes.web.feed import Feed
from img_recog.nodes.web.measurements import MeasurementTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.server import Server, address, listen
from img_recog.nodes.web.settings import WebSettings
from img_recog.nodes.web.simulation import ACTIONS, SimulationControl
from img_recog.nodes.web.tuning import Tuning
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC
from img_recog.recognition.proposal import propose_bounds
from img_recog.recognition.settings import DEFAULT_COLORS, color_names
from img_recog.ros import bag_recording, lifecycle, parameters
from img_recog.ros.bag_recording import BagRecording
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.ros.throttle import ThrottledWarning
from img_recog.settings import SettingError
from img_recog.teleoperation.settings import TeleopSettings

_POLL_PERIOD_S = 0.5
_MAX_IMAGE_BYTES = 200_000_000
_GRAPH_PERIOD_S = 1.0           # a drawn graph is shown to all pages for this time
_LIGHT = dot.Colors('transparent', '#111827', '#ffffff', '#eff6ff', '#b91c1c')
_DARK = dot.Colors('transparent', '#e5e7eb', '#1f2937', '#1e3a5f', '#f87171')
_FOLDER_ADVICE = 'start it in a folder where files can be written'
_START_TIMEOUT_S, _QUIET_S = 10.0, 1.5


class Web:
    """The parts of the page; `page.System` for it."""

    def __init__(self) -> None:
        settings = parameters.read(WebSettings)
        limits = parameters.read(TeleopSettings)
        parameters.warn_of_unknown(WebSettings, TeleopSettings)
        self._warn = ThrottledWarning()
        self._failure: Optional[BaseException] = None
        self._watching: Set[object] = set()
        self._lock = threading.Lock()
        self._graphs: Dict[Tuple[bool, bool], Tuple[float, bytes]] = {}
        self._reader: Optional[SystemReader] = None
        self._recording_lock = threading.Lock()
        self._recording: Optional[BagRecording] = None
        lifecycle.on_shutdown(self._end_recording)
        self.driving = Driving(limits)
        self.colors = Tuning(rospy.resolve_name('color_extract'))
        self.simulator = Tuning(rospy.resolve_name('gazebo'))
        self._simulation = SimulationControl()
        self._pictures = PictureTopics(_MAX_IMAGE_BYTES)
        self._feed = Feed(self._pictures, MeasurementTopics(), self.driving)
        sock = listen(settings.web_host, settings.web_port)
        port = sock.getsockname()[1]
        if port != settings.web_port:
            rospy.logwarn('port %d is taken: the page is at port %d', settings.web_port, port)
        token = secrets.token_urlsafe(16)
        self._address = address(sock, token)
        self._server = Server(
            Doors(self._application(), token, port, self._warn_of), sock, self._fail)
        NodeDiagnostics('web', 'none', self._report)

    def _application(self) -> FastAPI:
        app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)

        @app.websocket('/live')
        async def live(socket: WebSocket) -> None:
            await socket.accept()
            # the end of a connection is nothing to report, in the middle of a message too
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await self._feed.serve(socket)
        page.build(app, self)
        return app

    def spin(self) -> None:
        """Serve the page until the node is shut down."""
        _wait_for_other_nodes()
        # not in the log, which others can read: it has the token
        sys.stdout.write('the page: {}\n'.format(self._address))
        sys.stdout.flush()
        try:
            while not rospy.is_shutdown():
                if self._failure is not None:
                    raise self._failure
                time.sleep(_POLL_PERIOD_S)
        finally:
            self._server.close()

    def _warn_of(self, error: Exception) -> None:
        self._warn('the page failed: %s: %s', type(error).__name__, one_line(error))
        rospy.logdebug('%s', ''.join(traceback.format_exception(
            type(error), error, error.__traceback__)))

    def _fail(self, error: BaseException) -> None:
        self._failure = error

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        status.summary(DiagnosticStatus.OK, 'serving')
        status.add('pages', str(self._feed.viewers))

    # what the page shows and does, see page.System

    def picture_topics(self) -> List[Tuple[str, str, str]]:
        """Return topic, key of its title and color of each picture."""
        published: Set[str] = set()
        names, topics = list(DEFAULT_COLORS), {}
        try:
            published = {name for name, _ in rospy.get_published_topics()}
            given = rospy.get_param('color_extract', {})
            names = list(color_names(given.get(COLORS, names)))
            topics = {name: given.get(IMAGE_TOPIC.format(name)) for name in names}
        except (OSError, rospy.ROSException, rosgraph.MasterException, AttributeError,
                SettingError) as error:
            self._warn('the colors of color_extract: %s', one_line(error))
        found = [(rospy.resolve_name('usb_cam/image_raw'), 'camera', '')]
        for name in names:
            found.append((rospy.resolve_name(topics.get(name) or name + '_image'), 'mask', name))
        found.append((rospy.resolve_name('gazebo/view/image_raw'), 'view', ''))
        robot = rospy.resolve_name('camera/rgb/image_raw')
        return found + ([(robot, 'robot_camera', '')] if robot in published else [])

    def watch(self, page_: object, is_watched: bool) -> None:
        """Begin or end to follow the parameters for a page."""
        (self._watching.add if is_watched else self._watching.discard)(page_)
        for tuning in (self.colors, self.simulator):
            tuning.watch(bool(self._watching))

    def act(self, action: str) -> None:
        """Call a service of the simulator; raise UserError if that fails."""
        if action not in ACTIONS:
            raise UserError('there is no action {!r}'.format(action))
        self._simulation.call(action)

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Move the robot; raise UserError for a pose that is not allowed."""
        self._simulation.set_pose(x, y, yaw)

    def propose(self, topic: str, x: float, y: float, color: str) -> Dict[str, int]:
        """Set bounds of a color around that in a picture; return them."""
        picture = self._pictures.latest(topic)
        values = self.colors.values()
        if picture is None or color + '_hue_min' not in values:
            raise UserError('there is no picture of {} yet'.format(topic[:100]))
        image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
        bounds = propose_bounds(image, x, y)
        self.colors.change(**{'{}_{}'.format(color, part): value
                              for part, value in bounds.items()})
        return bounds

    def save_colors(self) -> str:
        """Save the parameters of the colors; return the path."""
        values = self.colors.values()
        names = page.color_names_in(values)
        if not names:
            raise UserError('color_extract does not answer', 'start it')
        path = _free_path('colors', '.yaml')
        text = yaml.safe_dump({COLORS: names, **values}, sort_keys=False)
        with files.atomic_write([path], _FOLDER_ADVICE) as (file,):
            file.write(text.encode())
        return path

    def record(self, is_wanted: bool) -> str:
        """Start or stop a recording; return its path."""
        with self._recording_lock:
            recording = self._recording
            if is_wanted == (recording is not None and recording.is_running):
                return self.recording()
            if recording is None or is_wanted:
                topics = list(map(rospy.resolve_name, bag_recording.TOPICS))
                self._recording = BagRecording(_free_path('recording', '.bag'), topics)
                return self._recording.path
            recording.stop()
            return recording.path

    def recording(self) -> str:
        """Return the path of the recording that runs, '' if there is none."""
        recording = self._recording
        return recording.path if recording is not None and recording.is_running else ''

    def _end_recording(self) -> None:
        if self.recording():
            with contextlib.suppress(UserError):
                self.record(False)

    def graph(self, is_dark: bool, leaves: bool) -> bytes:
        """Return the graph of nodes and topics as SVG; raise UserError if that fails."""
        with self._lock:
            drawn_s, picture = self._graphs.get((is_dark, leaves), (0.0, b''))
            if time.monotonic() - drawn_s > _GRAPH_PERIOD_S:
                self._reader = self._reader or SystemReader()
                shown = visible(self._reader.read().without(rospy.get_name()),
                                Choice(leaves=leaves))
                picture = dot.draw(dot.to_dot(shown, _DARK if is_dark else _LIGHT), 'svg')
                self._graphs[is_dark, leaves] = time.monotonic(), picture
            return picture


def _wait_for_other_nodes() -> None:
    """Wait until no more nodes start: what this node prints then is the end of the output."""
    nodes: Set[str] = set()
    master = rosgraph.Master(rospy.get_name())
    end_s = time.monotonic() + _START_TIMEOUT_S
    since_s = time.monotonic()
    while time.monotonic() < end_s and not rospy.is_shutdown():
        found = {node for topics in master.getSystemState() for _, users in topics
                 for node in users}
        if found != nodes:
            nodes, since_s = found, time.monotonic()
        if time.monotonic() - since_s > _QUIET_S:
            return
        time.sleep(_POLL_PERIOD_S)


def _free_path(name: str, extension: str) -> str:
    """Return the path of a new file NAME_1, NAME_2, ... in the user's folder."""
    paths = (files.user_output_path('{}_{}{}'.format(name, number, extension))
             for number in itertools.count(1))
    return next(path for path in paths if not any(
        os.path.exists(path + suffix) for suffix in ('', '.active')))


def main() -> int:
    """Run the node; return its exit code."""
    cv2.setNumThreads(1)
    return lifecycle.run('web', lambda: Web().spin())
