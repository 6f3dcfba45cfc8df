"""A simulation whose time the test lets pass."""
import contextlib
import inspect
import os
import time
from typing import Any, Callable, List, Optional

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from visualization_msgs.msg import MarkerArray

from img_recog.camera_arguments import CAMERA_TOPIC, ROBOT
from img_recog.conversions import image_msgs, plane_msgs
from img_recog.errors import UserError, one_line
from img_recog.testing import evidence, launching
from img_recog.testing.launching import Given, LaunchFile, of_reasons
from img_recog.testing.running import Running
from img_recog.testing.topics import Picture, Pose, pose_from_msg

__tracebackhide__, __unittest = of_reasons, True     # as pytest and unittest know them
_CAMERA, _VIEW = '/' + CAMERA_TOPIC, '/gazebo/view/image_raw'
_OUTLINES = '/gazebo/world_outlines'
_ODOMETRY, _IMAGE = 'nav_msgs/Odometry', 'sensor_msgs/Image'
_SIMULATOR = '/gazebo'
_FIRST_MESSAGE_S, _FIRST_STEP_S = 2.0, 0.1     # simulated
_VIEW_TIMEOUT_S = 10.0                          # of wall time
# other than those of demo.launch: what a test does not need, and nodes that die are to be seen
_DEFAULTS = {'paused': True, 'respawn': False, 'web': False, 'teleop': False, 'gui': False,
             'image_view': False, 'lockstep_at_timeout': 'end'}


class Simulation:
    """The simulator and the nodes of launch files, in time that stands unless the test steps it.

    To be used in a with statement, or by the fixture of img_recog.testing.fixtures. What it does
    is documented in doc/ci.md.
    """

    def __init__(self, launch: Given = None, camera: str = ROBOT, world: str = 'color_posts',
                 robot: Optional[str] = None, lockstep: str = 'none', recognition: bool = False,
                 real_time_factor: float = 0, name: str = '', results: str = '',
                 wall_timeout_s: float = 60.0, **demo_arguments: Any):
        """Start nothing yet.

        launch: a path, or ('package', 'file.launch'), either with a dict of arguments at the end,
        or a list of these. robot: path of a URDF or xacro file; None: the TurtleBot3 burger.
        camera, world, lockstep, recognition, real_time_factor, demo_arguments: of demo.launch.
        name: beginning of the names of files that are kept after a failure, by default that of the
        test. results: their folder, by default that of the JUnit file, or the current one.
        wall_timeout_s: how long nothing may happen before it is an error, of wall time.
        Raises UserError if there is no such launch file.
        """
        arguments = {**_DEFAULTS, 'camera': camera, 'world': world, 'lockstep': lockstep,
                     'recognition': recognition, 'real_time_factor': real_time_factor,
                     **demo_arguments}
        if robot is not None:
            path = arguments['urdf'] = os.path.abspath(os.path.expanduser(robot))
            if not os.path.isfile(path):
                raise UserError('robot: there is no file {}'.format(path),
                                'give the path of a URDF or xacro file')
        demo = launching.launch_files(('img_recog', 'demo.launch', arguments))
        self._files: List[LaunchFile] = demo + launching.launch_files(launch)
        self._name, self._results = name, results
        self._wall_timeout_s = wall_timeout_s
        self._running: Optional[Running] = None
        self._odometry: List[str] = []      # topics, of all robots
        self._moments = evidence.LastMoments()

    @property
    def _commands(self) -> str:
        """The topic of the commands for the first robot."""
        return ''.join(self._odometry[:1]).rpartition('/')[0] + '/cmd_vel'

    def __enter__(self) -> 'Simulation':
        self.start()
        return self

    def __exit__(self, kind: Optional[type], *_: Any) -> None:
        self.end(kind is not None and issubclass(kind, Exception))

    def start(self) -> None:
        """Start all nodes; as `with` does. Call `end` after it.

        Raises UserError for what the user gave, AssertionError if a node dies or does not come.
        """
        evidence.remove_old(self._evidence)
        self._running = running = Running(self._files, self._wall_timeout_s)
        try:
            running.wait_ready()
            types = running.types()
            self._odometry = sorted(topic for topic, kind in types.items() if kind == _ODOMETRY
                                    and _SIMULATOR in running.publishers(topic))
            for number, topic in enumerate(self._odometry):
                running.topics.subscribe(topic, Odometry, *([] if number else [self._sample]))
            running.topics.subscribe(self._commands, Twist)
            if types.get(_CAMERA) == _IMAGE:
                running.topics.subscribe(_CAMERA, Image)
            running.topics.subscribe(_OUTLINES, MarkerArray)
            running.wait_connected()
        except BaseException as error:
            self.end(isinstance(error, Exception))
            raise

    def end(self, is_failed: bool = False) -> None:
        """End all nodes. is_failed: whether to keep pictures, a film and the log before."""
        if self._running is None:
            return
        try:
            if is_failed:
                self._keep()
        finally:
            running, self._running = self._running, None
            running.end()

    @property
    def _all(self) -> Running:
        if self._running is None:
            raise UserError('the simulation does not run', 'use it in a with statement, or by the '
                            'fixture `simulation`')
        return self._running

    @property
    def time_s(self) -> float:
        """The simulated time in s, 0 at the start."""
        return self._all.time_s

    @property
    def log(self) -> List[str]:
        """The last lines that all nodes have printed."""
        return list(self._all.launch.log)

    def step(self, seconds: float) -> float:
        """Let simulated time pass, as fast as possible up to real_time_factor; return the time.

        seconds: a multiple of the step of the physics, 0.001 s. All messages that the simulator
        has sent in this time have come then. Raises AssertionError, with the reason, if a node
        dies, or if no time passes for wall_timeout_s.
        """
        self._all.step(seconds)
        return self.time_s

    def wait_until(self, condition: Callable[[], Any], timeout_s: float = 60.0,
                   description: str = '', period_s: float = 0.1, wall_timeout_s: float = 600.0
                   ) -> Any:
        """Let time pass until a condition is true; return its value.

        condition: is called at first, and after each period_s. timeout_s: of simulated time.
        description: of the condition, by default its docstring, name or source line.
        wall_timeout_s: limit in wall time. Raises AssertionError after one of both.
        """
        end_s, wall_end_s = self.time_s + timeout_s, time.monotonic() + wall_timeout_s
        while True:
            value = condition()
            if value:
                return value
            left_s = end_s - self.time_s
            is_late = time.monotonic() > wall_end_s
            if is_late or left_s < 1e-6:
                raise AssertionError('not within {:g} s {}: {}\n{}\n{}'.format(
                    wall_timeout_s if is_late else timeout_s,
                    'on the clock' if is_late else 'of simulated time',
                    description or _described(condition), self._state(), self._all.launch.tail()))
            self.step(min(period_s, left_s))

    def _state(self) -> str:
        poses = ['{}: {}'.format(topic, pose_from_msg(msg)) for topic, msg in (
            (topic, self._all.topics.newest(topic)) for topic in self._odometry) if msg]
        return '; '.join(['the time is {:.3f} s'.format(self.time_s), *poses])

    def pose(self, robot: str = '') -> Pose:
        """Return the newest pose of the odometry: the true one, unless odometry_source is encoder.

        robot: its namespace, if there are several. At the start, time passes until it comes.
        """
        topics = self._odometry
        found = [topic for topic in topics if topic.startswith('/{}/'.format(robot.strip('/')))
                 or not robot]
        if len(found) != 1:
            raise UserError('pose: got the robot {!r}'.format(robot), 'give one of {}'.format(
                ', '.join(repr(topic.rpartition('/')[0][1:]) for topic in topics) or 'none'))
        return pose_from_msg(self.message(found[0], Odometry))

    def image(self, topic: str = '') -> Picture:
        """Return the newest image, by default of the camera; see `message`."""
        msg = self.message(topic or _CAMERA, Image)
        return Picture(image_msgs.from_msg(msg), msg.header.stamp.to_sec())

    def message(self, topic: str, data_class: type) -> Any:
        """Return the newest message of a topic.

        The first call for a topic subscribes. Until a message has come, time passes, at most 2 s;
        raises AssertionError then, and UserError if the topic has another type.
        """
        running, name = self._all, rosgraph.names.resolve_name(topic, '/')
        known, wanted = running.topics.types, getattr(data_class, '_type')
        kind = known[name] if name in known else running.types().get(name)
        if kind not in (None, '*', wanted):
            raise UserError('the topic {} has the type {}, not {}'.format(name, kind, wanted))
        if name not in known:
            running.topics.subscribe(name, data_class)
            running.wait_connected()
        end_s = self.time_s + _FIRST_MESSAGE_S
        while running.topics.newest(name) is None:
            if self.time_s >= end_s:
                raise AssertionError('no message on {} in {:g} s of simulated time: {}'.format(
                    name, _FIRST_MESSAGE_S, running.reason_without(name, data_class)))
            self.step(_FIRST_STEP_S)
        return running.topics.newest(name)

    def _sample(self, msg: Odometry) -> None:
        """Keep what a film shows."""
        topics = self._all.topics
        command, image = topics.newest(self._commands), topics.newest(_CAMERA)
        self._moments.add(pose_from_msg(msg), command.linear.x if command else 0.0, image)

    @property
    def _evidence(self) -> str:
        """The beginning of the paths of the files for a test that has failed."""
        return os.path.join(evidence.folder(self._results), evidence.name(self._name))

    def _keep(self) -> None:
        """Write the files for a test that has failed; log their names, or why there is none."""
        topics, path = self._all.topics, self._evidence
        log, image = self.log, topics.newest(_CAMERA)
        view, outlines = self._view(), topics.newest(_OUTLINES)
        robot = self._commands.rpartition('/')[0] + '/'
        nodes = [name for name in self._all.nodes() if name.startswith(robot)]
        kept = []
        for suffix, write in zip(evidence.SUFFIXES, (
                lambda path: evidence.write_log(path, log),
                image and (lambda path: evidence.write_picture(path, image)),
                view and (lambda path: evidence.write_picture(path, view)),
                lambda path: self._moments.write_film(
                    path, plane_msgs.outlines_from_msg(outlines) if outlines else [],
                    evidence.colors_of(nodes)))):
            try:
                if write:
                    write(path + suffix)
                    kept.append(path + suffix)
            except UserError as error:
                rospy.logwarn('%s', one_line(error))
        rospy.loginfo('the test has failed; see %s', ', '.join(kept))

    def _view(self) -> Optional[Image]:
        """Return an image of the view from above, None if none comes."""
        topics = self._all.topics
        try:
            topics.subscribe(_VIEW, Image)
            self._all.wait_while_standing(lambda: topics.newest(_VIEW), _VIEW_TIMEOUT_S)
        except AssertionError:      # the simulator has ended
            pass
        return topics.newest(_VIEW)


def _described(condition: Callable[[], Any]) -> str:
    """Return the docstring of a function, its name, or the source line of a lambda."""
    name = getattr(condition, '__name__', repr(condition))
    if condition.__doc__:
        return condition.__doc__.strip().splitlines()[0]
    if name == '<lambda>':
        with contextlib.suppress(OSError, TypeError):
            return inspect.getsource(condition).strip()
    return name
