"""A function of the user in a replay: what it gets, what it may return, what is refused."""
import sys

import genpy
import numpy as np
import pytest
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from sensor_msgs.msg import CameraInfo

from img_recog.errors import UserError
from img_recog.recognition.commands import Command
from img_recog.recordings.camera_infos import of_calibration
from img_recog.recordings.frames import Frame
from img_recog.replay.function_recognition import FunctionRecognition, UserFunction, load
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal
from img_recog_helpers.replaying import BLUE, frame

TWIST = Twist(Vector3(0.5, 0.25, 0.0), Vector3(0.0, 0.0, -1))
WITHOUT_LINEAR = Twist()
WITHOUT_LINEAR.linear = None


@pytest.fixture
def write(tmp_path, monkeypatch):
    """A function that writes a module of the user into the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, 'path', list(sys.path))
    monkeypatch.setattr(sys, 'dont_write_bytecode', True)
    before = set(sys.modules)

    def write(text, name='users_module.py'):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    yield write
    for name in set(sys.modules) - before:
        if name.startswith('users_'):
            del sys.modules[name]


def recognition(call, is_strict=False, file=__file__):
    return FunctionRecognition(UserFunction('m:f', call, file), of_calibration(None), is_strict)


def decided(made, *frames):
    measured = made.measure(frames)
    return [made.decide(each, each.frame.stamp_ns / 1e9) for each in measured]


def test_it_gets_an_image_of_its_own_the_stamp_and_the_camera_info():
    given = []
    color = frame(7, 1500000000, BLUE)
    rgb = Frame(8, 2 * 10 ** 9, color.header, np.ascontiguousarray(color.image[..., ::-1]), 'rgb8')
    rgb.image.flags.writeable = False

    def function(image, stamp, camera_info):
        given.append((image.copy(), stamp, camera_info))
        image[:] = 0
    assert decided(recognition(function), color, rgb) == [[], []]
    for (image, stamp, info), stamp_ns in zip(given, (1500000000, 2 * 10 ** 9)):
        assert image.dtype == np.uint8 and np.array_equal(image, color.image)
        assert image[0, 0].tolist() == list(BLUE)
        assert type(stamp) is genpy.Time and stamp.to_nsec() == stamp_ns
        assert type(info) is CameraInfo and (info.width, info.height) == (200, 40)
        assert info.header.stamp == stamp and info.header.frame_id == 'head_camera'


@pytest.mark.parametrize('result, commands', [
    (None, []), (TWIST, [Command(0.5, -1.0, 0.25)]),
    (TwistStamped(twist=TWIST), [Command(0.5, -1.0, 0.25)]), (Twist(), [Command(0.0)])])
def test_its_result_is_the_command(result, commands):
    made = recognition(lambda image, stamp, camera_info: result)
    assert decided(made, frame(0, 0)) == [commands]
    assert [type(value) for command in commands for value in command] == [float] * 3 * len(
        commands)
    assert made.wait(1.0) == made.end() == made.warnings == []


def divide(image, stamp, camera_info):
    if stamp.secs:
        np.zeros(3).reshape(2)
    return None


def leave(image, stamp, camera_info):
    return sys.exit('enough') if stamp.secs else None


def of(result):
    return lambda image, stamp, camera_info: result if stamp.secs else None


@pytest.mark.parametrize('function, words', [
    (divide, 'ValueError: cannot reshape array of size 3 into shape (2,) '
     '(test_function_recognition.py, line {})'.format(divide.__code__.co_firstlineno + 2)),
    (leave, 'SystemExit: enough (test_function_recognition.py, line {})'.format(
        leave.__code__.co_firstlineno + 1)),
    (of(0.5), 'it returns float, expected geometry_msgs/Twist, TwistStamped or None'),
    (of(Twist(Vector3(float('nan'), 0, 0), Vector3())),
     'it returns a bad command: Twist: got linear.x=nan, expected finite numbers'),
    (of(Twist(Vector3('a', 0, 0), Vector3())), 'it returns a bad command: must be real number'),
    (of(WITHOUT_LINEAR), 'it returns a bad command: ')])
def test_a_frame_for_which_it_fails_has_no_command(function, words):
    made, frames = recognition(function), [frame(number, number * 10 ** 9) for number in range(3)]
    assert decided(made, *frames) == [[], [], []]
    assert made.end() == []
    line, = made.warnings
    assert line.startswith('m:f fails for 2 of 3 frames; the first is frame 1 at 1.000 s: ')
    assert words in line
    line = refusal(decided, recognition(function, is_strict=True), *frames)
    assert line.startswith('m:f fails for frame 1 at 1.000 s: ') and words in line


def test_a_function_that_fails_for_all_frames_ends_the_replay():
    made = recognition(of(1))
    decided(made, frame(0, 10 ** 9))
    with pytest.raises(UserError, match='m:f fails for 1 of 1 frames; the first is frame 0'):
        made.end()


@pytest.mark.parametrize('name, file', [
    ('users_module:f', 'users_module.py'), ('users_module.py:f', 'users_module.py'),
    ('users_package.inner:f', 'users_package/inner.py'), ('some/users-file.py:f',
                                                          'some/users-file.py')])
def test_a_module_is_found_in_the_current_folder_and_a_file_anywhere(write, tmp_path, name, file):
    write('def f(image, stamp, camera_info):\n    return 5\n', file)
    found = load(name)
    assert (found.name, found.file, found.call(1, 2, 3)) == (name, str(tmp_path / file), 5)


def test_a_file_finds_the_modules_beside_it(write):
    write('f = 7\n', 'some/users_neighbor.py')
    write('import users_neighbor\ndef f(*_): return users_neighbor.f\n', 'some/users_file.py')
    assert load('some/users_file.py:f').call(1, 2, 3) == 7


def test_a_method_of_an_object_has_state(write):
    write('class Counter:\n    n = 0\n    def __call__(self, image, stamp, info):\n'
          '        self.n += 1\n        return self.n\n    def take(self, *args): return args\n'
          'counter = Counter()\n')
    counter = load('users_module:counter').call
    assert (counter(1, 2, 3), counter(1, 2, 3)) == (1, 2)
    assert load('users_module:counter.take').call(1, 2, 3) == (1, 2, 3)


def test_names_that_are_refused(write):
    write('N = 3\ndef one(image): pass\ndef four(a, b, c, d): pass\n')
    expected.check_cases('refused/functions.txt', lambda name: refusal(load, name))


@pytest.mark.parametrize('text, words', [
    ('def f(:\n', '(users_module.py, line 1)'),
    ('\nimport users_none\n', "ModuleNotFoundError: No module named 'users_none' "
     '(users_module.py, line 2)'),
    ('1 / 0\n', 'ZeroDivisionError: division by zero (users_module.py, line 1)'),
    ('import sys\nsys.exit(3)\n', 'SystemExit: 3 (users_module.py, line 2)')])
@pytest.mark.parametrize('place', ['users_module', 'users_module.py'])
def test_a_module_that_cannot_be_loaded(write, place, text, words):
    write(text)
    line = refusal(load, place + ':f')
    assert line.startswith('--recognize: cannot load {}: '.format(place)) and words in line
