"""A function of the user that takes the place of the color recognition in a replay."""
import importlib
import importlib.util
import inspect
import operator
import os
import sys
import traceback
from types import ModuleType
from typing import Any, Callable, List, NamedTuple

import genpy
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Header

from img_recog.conversions import twist_msgs
from img_recog.errors import UserError, one_line, shortened
from img_recog.recognition.areas import bgr_copy
from img_recog.recognition.commands import Command
from img_recog.recordings.camera_infos import CameraInfos
from img_recog.replay.chain import SECOND_NS, Frame, FrameMeasurement, Recognition

_ARGUMENTS = 'image, stamp, camera_info'
_WANTED = 'give MODULE:FUNCTION or FILE.py:FUNCTION'


class UserFunction(NamedTuple):
    """A function, its name in messages, and the file of its module."""

    name: str
    call: Callable[..., Any]
    file: str


class FunctionRecognition(Recognition):
    """Decides on the command for each frame by a function.

    A frame for which it fails has no command. The other commands are up to the function too: there
    are none while no frame arrives.
    """

    def __init__(self, function: UserFunction, camera_infos: CameraInfos, is_strict: bool):
        """Use a function; is_strict: the first frame for which it fails ends the replay."""
        super().__init__()
        self._function, self._camera_infos, self._is_strict = function, camera_infos, is_strict
        self._frames = self._failed = 0
        self._first_problem = ''

    def decide(self, measurement: FrameMeasurement, time_s: float) -> List[Command]:
        """Return its command; UserError if it fails and that ends the replay."""
        self._frames += 1
        try:
            return self._call(measurement.frame)
        except _Failed as error:
            problem = 'frame {} at {:.3f} s: {}'.format(measurement.frame.number, time_s, error)
            if self._is_strict:
                raise UserError('{} fails for {}'.format(self._function.name, problem))
            self._failed += 1
            self._first_problem = self._first_problem or problem
            return []

    def end(self) -> List[Command]:
        """Return no command; raise UserError if the function has failed for all frames."""
        if self._failed:
            problem = '{} fails for {} of {} frames; the first is {}'.format(
                self._function.name, self._failed, self._frames, self._first_problem)
            if self._failed == self._frames:
                raise UserError(problem)
            self.warnings.append(problem)
        return []

    def _call(self, frame: Frame) -> List[Command]:
        stamp = genpy.Time(*divmod(frame.stamp_ns, SECOND_NS))
        camera_info = self._camera_infos(frame)
        camera_info.header = Header(frame.header.seq, stamp, frame.header.frame_id)
        try:
            result = self._function.call(bgr_copy(frame.image, frame.encoding), stamp, camera_info)
        except (Exception, SystemExit) as error:
            raise _Failed(_described(error, self._function.file))
        if result is None:
            return []
        if not isinstance(result, (Twist, TwistStamped)):
            raise _Failed('it returns {}, expected geometry_msgs/Twist, TwistStamped or None'
                          .format(type(result).__name__))
        try:
            return [Command(*map(float, twist_msgs.from_msg(result)))]
        except (UserError, AttributeError, OverflowError, TypeError, ValueError) as error:
            raise _Failed('it returns a bad command: {}'.format(one_line(error)))


class _Failed(Exception):
    """The function has no usable result for a frame."""


def load(name: str) -> UserFunction:
    """Return the function of a module, or of a file of Python: MODULE:FUNCTION, FILE.py:FUNCTION.

    The current folder, or that of the file, is the first one in which Python looks for modules.
    FUNCTION may also be a method of an object of the module: OBJECT.METHOD.
    Raises UserError if there is none that takes three arguments.
    """
    place, _, attribute = name.rpartition(':')
    if not place or not attribute:
        raise _refused('got {}'.format(shortened(name)), _WANTED)
    module = _load_file(place) if place.endswith('.py') else _load_module(place)
    try:
        function = operator.attrgetter(attribute)(module)
    except AttributeError as error:
        raise _refused('{} has no {}: {}'.format(place, shortened(attribute), one_line(error)),
                       'give the name of a function in it')
    if not callable(function):
        raise _refused('{} is {}, expected a function'.format(name, type(function).__name__),
                       'define {}({})'.format(attribute, _ARGUMENTS))
    try:
        inspect.signature(function).bind(*_ARGUMENTS.split())
    except ValueError:
        pass            # of a function that is not written in Python, it is not known
    except TypeError as error:
        raise _refused('{} cannot be called with ({}): {}'.format(
            name, _ARGUMENTS, one_line(error)), 'define {}({})'.format(attribute, _ARGUMENTS))
    return UserFunction(name, function, getattr(module, '__file__', None) or '')


def _load_file(place: str) -> ModuleType:
    path = os.path.abspath(os.path.expanduser(place))
    if not os.path.isfile(path):
        raise _refused('no file {}'.format(shortened(place)), _WANTED)
    name = os.path.splitext(os.path.basename(path))[0]
    spec: Any = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, os.path.dirname(path))
    # as for an import; but a file with the name of a module of Python does not replace that
    sys.modules.setdefault(name, module)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise _refused('cannot load {}: {}'.format(place, _described(error, path)), '')
    return module


def _load_module(place: str) -> ModuleType:
    sys.path.insert(0, os.getcwd())
    missing = _refused('no module {}'.format(shortened(place)), _WANTED +
                       '; modules are looked for in the current folder and in PYTHONPATH')
    if not all(part.isidentifier() for part in place.split('.')):
        raise missing
    try:
        return importlib.import_module(place)
    except (Exception, SystemExit) as error:
        name = isinstance(error, ModuleNotFoundError) and error.name
        if name and (place + '.').startswith(name + '.'):
            raise missing
        raise _refused('cannot load {}: {}'.format(place, _described(error, '')), '')


def _refused(problem: str, advice: str) -> UserError:
    return UserError('--recognize: ' + problem, advice)


def _described(error: BaseException, file: str) -> str:
    """Return an exception with its line in a file, or else the one that raised it, as one line."""
    text = '{}: {}'.format(type(error).__name__, one_line(error))
    lines = [(frame.f_code.co_filename, line)
             for frame, line in traceback.walk_tb(error.__traceback__)]
    if isinstance(error, SyntaxError):      # its text names the line
        return text
    lines = ([each for each in lines if each[0] == file] or
             [each for each in lines if not each[0].startswith('<')])
    return '{} ({}, line {})'.format(text, os.path.basename(lines[-1][0]), lines[-1][1])
