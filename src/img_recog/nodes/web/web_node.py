"""The node web: a page that shows the running system and drives the robot.

Several robots are found by their topics ROBOT/cmd_vel; a page shows one of them.
Publishes, for each robot that was shown: cmd_vel (geometry_msgs/Twist, 20 Hz of wall time while a
visitor drives, then zeros), gazebo/set_pose (geometry_msgs/PoseStamped; gazebo/ROBOT/set_pose);
once there is a map, move_base_simple/goal (geometry_msgs/PoseStamped) and initialpose
(geometry_msgs/PoseWithCovarianceStamped); /diagnostics (diagnostic_msgs/DiagnosticArray, 1 Hz).
Subscribes, while somebody looks at a page: usb_cam/image_raw (sensor_msgs/Image) and other images,
odom (nav_msgs/Odometry), scan (sensor_msgs/LaserScan), color_detection (sensor_msgs/PointCloud),
gazebo/real_time_factor (std_msgs/Float64), gazebo/world_outlines (visualization_msgs/MarkerArray),
/rosout_agg (rosgraph_msgs/Log), and the topics that it publishes; if there is a map, map
(nav_msgs/OccupancyGrid), map_updates (map_msgs/OccupancyGridUpdate), /tf and /tf_static
(tf2_msgs/TFMessage), and all topics of type nav_msgs/Path.
Calls the services of gazebo that pause and reset, the service ~yield of the other publishers of
cmd_vel, and dynamic_reconfigure of color_extract and gazebo.
Reads: ~web_host, ~web_port (WebSettings), ~max_linear_velocity, ~max_angular_velocity
(VelocityLimits).
"""
import contextlib
import secrets
import sys
import time
import traceback
from typing import Optional, Set

import cv2
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from fastapi import FastAPI, WebSocket, WebSocketDisconnect
from fastapi.concurrency import run_in_threadpool

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.nodes.web import page
from img_recog.nodes.web.authentication import Authentication
from img_recog.nodes.web.feed import Feed
from img_recog.nodes.web.measurements import SystemTopics
from img_recog.nodes.web.page import Server, address, listen, parse_in_turn, report_errors
from img_recog.nodes.web.page_elements import Shared
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.shown_robots import ShownRobots, WebSettings, resolve
from img_recog.nodes.web.tabs import TABS
from img_recog.nodes.web.tuning import Tuning
from img_recog.processes import bag_recording
from img_recog.processes.bag_recording import BagRecording, RecordingSwitch
from img_recog.ros import lifecycle, master_calls, parameters
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.ros.throttle import Throttle, ThrottledWarning
from img_recog.teleoperation import VelocityLimits

_POLL_PERIOD_S = 0.5
_START_TIMEOUT_S, _QUIET_S = 10.0, 1.5
_REMINDER_PERIOD_S = 5.0
_TRY_AGAIN = 1013               # a close code of IANA's registry of WebSocket close codes


class Web:
    """Serves the page, and looks for robots and for the end of a recording meanwhile."""

    def __init__(self) -> None:
        settings = parameters.read(WebSettings)
        limits = parameters.read(VelocityLimits)
        parameters.warn_of_unknown(WebSettings, VelocityLimits)
        self._warn = ThrottledWarning()
        self._failure: Optional[Exception] = None
        self._pictures = PictureTopics()
        topics = SystemTopics(tab.topics for tab in TABS if tab.topics is not None)
        self._robots = ShownRobots(limits, self._pictures, topics)
        self._recorder = RecordingSwitch(self._start_recording)
        lifecycle.on_shutdown(self._end_recording)
        self._feed = Feed(self._pictures, self._warn_of)
        sock = listen(settings.web_host, settings.web_port)
        port = sock.getsockname()[1]
        if port != settings.web_port:
            rospy.logwarn('port %d is taken: the page is at port %d', settings.web_port, port)
        report_errors(self._warn_of)
        parse_in_turn()
        token = secrets.token_urlsafe(16)
        self._address = address(sock, token)
        reminder = Throttle(_REMINDER_PERIOD_S)
        self._server = Server(Authentication(
            self._application(), token, port, self._warn_of,
            lambda: self._show_address() if reminder.ready() else None), sock, self._fail)
        NodeDiagnostics('web', 'none', self._report)

    def _application(self) -> FastAPI:
        app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)

        @app.websocket('/live')
        async def live(socket: WebSocket) -> None:
            await socket.accept()
            # the end of a connection is nothing to report, in the middle of a message too
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                name = socket.query_params.get('robot', '')
                robot = await run_in_threadpool(self._robots.get, name)
                if robot.name != name:      # never show and drive another one instead
                    await socket.close(_TRY_AGAIN)
                    return
                self._pictures.allow(each.topic for each in await run_in_threadpool(
                    robot.picture_topics))
                await self._feed.serve(socket, robot)
        page.build(app, Shared(self._robots, Tuning(rospy.resolve_name('gazebo')),
                               self._recorder))
        return app

    def spin(self) -> None:
        """Serve the page until the node is shut down."""
        _wait_for_other_nodes()
        self._robots.update()
        self._show_address()
        try:
            while not rospy.is_shutdown():
                if self._failure is not None:
                    raise self._failure
                if self._feed.viewers:
                    self._robots.update()
                self._check_recording()
                time.sleep(_POLL_PERIOD_S)
        finally:
            self._server.close()

    def _show_address(self) -> None:
        # not in the log, which others can read: it has the token
        sys.stdout.write('the page: {}\n'.format(self._address))
        sys.stdout.flush()

    def _warn_of(self, error: Exception) -> None:
        self._warn('the page failed: %s: %s', type(error).__name__, one_line(error))
        rospy.logdebug('%s', ''.join(traceback.format_exception(
            type(error), error, error.__traceback__)))

    def _fail(self, error: Exception) -> None:
        self._failure = error

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        status.summary(DiagnosticStatus.OK, 'serving')
        status.add('pages', str(self._feed.viewers))

    def _start_recording(self) -> BagRecording:
        topics = {name for topic in bag_recording.TOPICS for name in (
            rospy.resolve_name(topic), *(resolve(robot, topic) for robot in self._robots.names))}
        return BagRecording(files.free_output_path('recording', '.bag'), sorted(topics),
                            is_ending=rospy.core.is_shutdown_requested)

    def _check_recording(self) -> None:
        """Say it when a recording has ended by itself."""
        try:
            path = self._recorder.check()
            if path:
                rospy.loginfo('the recording %s has ended: it has its largest size', path)
        except UserError as error:
            rospy.logerr('%s', one_line(error))

    def _end_recording(self) -> None:
        with contextlib.suppress(UserError):
            self._recorder.record(False)


def _wait_for_other_nodes() -> None:
    """Wait until no more nodes start: what this node prints then is the end of the output."""
    nodes: Set[str] = set()
    end_s = time.monotonic() + _START_TIMEOUT_S
    since_s = time.monotonic()
    while time.monotonic() < end_s and not rospy.is_shutdown():
        try:
            found = master_calls.calls().state().nodes
        except OSError:     # it may come back
            found = set()
        if found != nodes or not found:
            nodes, since_s = found, time.monotonic()
        if time.monotonic() - since_s > _QUIET_S:
            return
        time.sleep(_POLL_PERIOD_S)


def main() -> int:
    """Run the node; return its exit code."""
    cv2.setNumThreads(1)
    return lifecycle.run('web', lambda: Web().spin(), {'~': (WebSettings, VelocityLimits)})
